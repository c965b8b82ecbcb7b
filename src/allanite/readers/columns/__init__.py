"""From columns with headers to channels with units."""
