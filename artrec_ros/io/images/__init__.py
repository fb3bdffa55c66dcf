"""Images and cameras: bytes to arrays, calibration files, videos."""
