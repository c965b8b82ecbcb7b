"""What keeps hostile files in bounds."""
