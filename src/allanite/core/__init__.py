"""Values that everything speaks in: records, curves, models, fits; and the units, files and errors at the border."""
