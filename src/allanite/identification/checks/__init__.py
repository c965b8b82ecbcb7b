"""Whether the model explains the record, and the residuals."""
