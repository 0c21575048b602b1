"""An independent judge of what is measured of runs: ``python -m benchmarks.judge``.

It executes runs of all strategies, bodies, drives, range finders, radios and faults, has them
measured by the package, and measures them again with other means: views by CGAL (`pyvispoly`),
areas by overlays of polygons (GEOS), distances by dense sampling. It takes from the package the
recordings and nothing that computes: nothing of `multisrt.geometry`, and of `multisrt.analysis`
only what it judges.
"""
