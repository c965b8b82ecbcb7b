"""What coefficients mean: sentences about a result, grades of sensors, and tables of likely causes by device."""
