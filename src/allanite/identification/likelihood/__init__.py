"""The Whittle likelihood of a record, and which terms it asks for."""
