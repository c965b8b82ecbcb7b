"""Every averaging time at once: compiled frames and Theo1 by FFT."""
