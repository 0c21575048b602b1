"""Numbers, arrays of points and the way kernels are compiled."""
