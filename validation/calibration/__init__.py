"""Suite `calibration`: fingers calibrated on subjects, and twins of known tissue."""
