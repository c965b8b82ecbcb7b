"""What people look at of the angle sensors: table, figures, page, JSON and CSV of their harmonics and of a plan."""
