"""The Whittle likelihood of a record, and the selection of terms."""
