import math, numpy as np, msgspec, time
import multisrt as ms
from multisrt.geometry.grids.sight import in_sight
from multisrt.geometry.grids.occupancy import FREE, OCCUPIED
from multisrt.geometry.numerics.kernel import kernel
from multisrt.geometry.grids.unknown_area import unknown_areas
from multisrt.informed.routes import Costs, improve, route_times, insert, objective
from multisrt.robots.frontier.explore import FrontierExplorer
from multisrt.robots.frontier.nearness import drive_by_option
from multisrt.robots.frontier.options import BiddingOptions
from multisrt.robots.frontier.wavefront_costs import full_table, Table
from multisrt.robots.frontier.wavefront_rules import settle_on
from multisrt.robots.strategy import Strategy
from multisrt.robots.frontier.utility import apart
from multisrt.robots.frontier.gain import areas_beyond

class Options(BiddingOptions, frozen=True, kw_only=True, forbid_unknown_fields=True):
    rho: float = 0.6        # share of the range from which a frontier is looked at
    service: float = 0.3    # seconds for a square metre beyond
    g0: float = 0.0
    stick: float = 1.0      # seconds
    turn: float = 1.0       # seconds per radian of first turn
    lat: float = 0.0
    most: int = 24
    mark: int = 5

@kernel
def sees(free, cands, marks, radii):
    v, m = cands.shape[0], marks.shape[0]
    out = np.zeros((v, m), np.bool_)
    for i in range(v):
        for j in range(m):
            dr, dc = cands[i, 0]-marks[j, 0], cands[i, 1]-marks[j, 1]
            if dr*dr+dc*dc <= radii[j]*radii[j]:
                out[i, j] = in_sight(free, cands[i, 1]+0.5, cands[i, 0]+0.5, marks[j, 1], marks[j, 0])
    return out

def cover(S, weight, near):
    """greedy; of equal ones the nearest"""
    left = S.any(axis=0); chosen = []
    S = S.copy()
    while left.any():
        val = (S & left) @ weight
        best = val.max()
        if best <= 0: break
        c = np.flatnonzero(val >= 0.999*best)
        i = int(c[np.argmin(near[c])])
        chosen.append(i); left &= ~S[i]
    # drop
    k = len(chosen)-1
    while k >= 0:
        rest = chosen[:k]+chosen[k+1:]
        if rest and (S[rest].any(axis=0) | ~S[chosen].any(axis=0)).all(): chosen = rest
        k -= 1
    return chosen

def choose(robot, because):
    o = robot.options
    table = full_table(robot)
    m0 = len(table.targets)
    if m0 == 0 or not np.isfinite(table.costs[table.row]).any():
        return (yield from settle_on(robot, table, None, "closest", because))
    raster = robot.raster; cell = raster.cell_m; R = robot.me.range_m / cell
    groups = robot.frontiers.placed()
    free = raster.cells == FREE
    marks, gid = [], []
    for g, (group, place) in enumerate(groups):
        idx = np.column_stack(raster.indices_of(group.cells))
        idx = idx[::o.mark] if len(idx) > o.mark else idx[len(idx)//2:len(idx)//2+1]
        marks.append(idx); gid += [g]*len(idx)
    marks = np.vstack(marks).astype(np.int64); gid = np.array(gid)
    radii = np.full(len(marks), o.rho*R)
    here = robot.indices_of(np.array([robot.at[:2]]))
    own_view = sees(free, here.astype(np.int64), marks, np.full(len(marks), R))[0]
    d_here = np.hypot(*(marks-here[0]).T)
    radii = np.where(own_view, np.minimum(radii, 0.7*d_here), radii)
    # candidates: lattice of passable cells near marks
    rows, cols = np.nonzero(raster.passable)
    r0, c0 = raster.row, raster.column
    keep = ((rows+r0) % 4 == 0) & ((cols+c0) % 4 == 0)
    cands = np.column_stack([rows[keep], cols[keep]]).astype(np.int64)
    gt = robot.indices_of(table.targets).astype(np.int64)
    cands = np.vstack([gt, cands])
    field = table.field
    with robot.around_bodies():
        dist = field.distance(cands)
    ok = np.isfinite(dist); cands = cands[ok]; dist = dist[ok]
    near_marks = np.zeros(len(cands), bool)
    S = sees(free, cands, marks, radii)
    # a group's own target always shows the group
    tgt_row = np.cumsum(ok)-1
    for g in range(m0):
        if ok[g]: S[tgt_row[g], gid == g] = True
    some = S.any(axis=1); cands, dist, S = cands[some], dist[some], S[some]
    weight = np.ones(len(marks))
    chosen = cover(S, weight, dist)
    if not chosen:
        j = int(np.argmin(table.costs[table.row])); return (yield from settle_on(robot, table, j, "closest", because))
    V = cands[chosen]; SV = S[chosen]
    places = np.array([raster.centre_of(*raster_cell(raster, v)) for v in V])
    if len(V) > o.most:
        k = np.argsort(dist[chosen])[:o.most]; V, SV, places = V[k], SV[k], places[k]
    m = len(V)
    speed = robot.me.kinematics.speed_m_s
    # robots: own free, others committed to goals
    reports = robot.team.mates.reports
    starts, rem = [], []
    for n in table.robots:
        if n == robot.me.robot: starts.append(robot.at[:2]); rem.append(0.0)
        else:
            r = reports[n]
            if r.goal is not None and r.remaining_m > 0: starts.append(r.goal); rem.append(r.remaining_m/speed)
            else: starts.append(r.place[:2]); rem.append(0.0)
    # marks that others are going to look at are theirs: do not plan viewpoints for them
    n = len(starts)
    D = np.full((m+n, m+n), np.inf)
    for a in range(m):
        f = robot.field(*places[a].tolist())
        if f is None: continue
        D[a, :m] = f.distance(V)
    for i in range(n):
        if i == table.row:
            with robot.around_bodies(): D[m+i, :m] = field.distance(V)
        else:
            f = robot.field(*starts[i])
            if f is not None: D[m+i, :m] = f.distance(V)
    D[:m, :m] = np.minimum(D[:m, :m], D[:m, :m].T)
    area = areas_beyond(robot, places)
    # shared areas: weight by share of marks
    T = D / speed
    T[:, :m] += (o.service*(area + o.g0))[None, :]
    for i in range(n): T[m+i, :m] += rem[i]
    x, y, h = robot.at
    ang = np.abs((np.arctan2(places[:, 1]-y, places[:, 0]-x) - h + math.pi) % (2*math.pi) - math.pi)
    T[m+table.row, :m] += o.turn*ang
    if robot.goal is not None:
        same = np.hypot(*(places-np.array(robot.goal.place)).T) < 0.6
        T[m+table.row, :m] -= np.where(same, o.stick, 0.0)
    reach = np.flatnonzero(np.isfinite(T[m:, :m]).any(axis=0))
    big = 1e6
    T = np.where(np.isfinite(T), T, big)
    costs = Costs(time_s=T[None], angle=np.zeros((1, m+n, m+n)), turn_s=np.zeros(1), kind=np.zeros(n, np.int64), heading=np.zeros(n), home=False)
    routes = np.full((n, m+1), -1, np.int64); sizes = np.ones(n, np.int64)
    routes[:, 0] = m+np.arange(n)
    far = T[m:, :m].min(axis=0)
    for j in sorted(reach.tolist(), key=lambda j: (-far[j], j)):
        best = None
        times = route_times(routes, sizes, costs)
        for i in range(n):
            for p in range(1, sizes[i]+1):
                a = routes[i, p-1]
                add = T[a, j]
                if p < sizes[i]: add += T[j, routes[i, p]] - T[a, routes[i, p]]
                t = times.copy(); t[i] += add
                v = (objective(t), add)
                if best is None or v < best[0]: best = (v, i, p)
        _, i, p = best; insert(routes[i], sizes[i], p, j); sizes[i] += 1
    routes, sizes = improve(routes, sizes, costs)
    row = table.row
    if sizes[row] > 1: j = int(routes[row, 1])
    else: j = int(np.argmin(T[m+row, :m]))
    out = Table(targets=places, robots=table.robots, costs=np.where(D[m:, :m] < big, D[m:, :m], np.inf), field=field, row=row)
    if not np.isfinite(out.costs[row, j]):
        j = int(np.argmin(table.costs[table.row])); return (yield from settle_on(robot, table, j, "closest", because))
    return (yield from settle_on(robot, out, j, "closest", because))

def raster_cell(raster, v):
    return int(v[0])+raster.row, int(v[1])+raster.column

from multisrt.robots.frontier.driving import drive
def drive_on(robot, goal): return drive(robot, goal, all_the_way=True)
def explorer(me, options): return FrontierExplorer(me, options, choose, drive_on)
VIEWS = Strategy(name="views", summary="prototype", options=Options, explorer=explorer)
ms.register(VIEWS)
