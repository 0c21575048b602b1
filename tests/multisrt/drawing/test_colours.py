import numpy as np

from multisrt.drawing.colours import ROBOT_COLOURS, RobotStyles


def test_sixty_four_robots_differ():
    looks = {(s.stroke, s.dashes_mm) for s in (RobotStyles.of(k).edge for k in range(64))}
    assert len(looks) == 64
    assert RobotStyles.of(64) == RobotStyles.of(0)
    assert len({RobotStyles.of(k).area.fill for k in range(32)}) == 32
    assert len({RobotStyles.of(k).edge.dashes_mm for k in range(8)}) == 8


def test_colours_of_neighbours_differ_without_seeing_green():
    # Machado, Oliveira and Fernandes 2009: deuteranopia, on linear RGB.
    deuteranopia = np.array(
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ]
    )
    rgb = np.array([[int(c[i : i + 2], 16) / 255 for i in (1, 3, 5)] for c in ROBOT_COLOURS])
    seen = np.clip((rgb**2.2) @ deuteranopia.T, 0, 1) ** (1 / 2.2)
    apart = np.linalg.norm(seen - np.roll(seen, 1, axis=0), axis=1)
    assert apart.min() > 0.15
