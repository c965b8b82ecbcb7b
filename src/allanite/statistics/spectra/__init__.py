"""Power spectral densities: Welch and multitaper."""
