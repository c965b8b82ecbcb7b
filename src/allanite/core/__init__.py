"""The values of the package (records, curves, models, fits), units, files and errors."""
