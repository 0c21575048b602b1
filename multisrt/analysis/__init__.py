"""What is measured of a run, from its recording and the truth."""
