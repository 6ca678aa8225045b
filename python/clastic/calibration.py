"""placeholder"""
Calibration = Parameter = Target = calibrate = None
