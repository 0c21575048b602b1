PRAGMA application_id = 1297306196;
PRAGMA user_version = 2;
BEGIN TRANSACTION;
CREATE TABLE meta (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
INSERT INTO "meta" VALUES('asked','1');
INSERT INTO "meta" VALUES('experiment','{"name":"Base","environments":[{"name":"open","parameters":{"size_m":6.0}}],"strategies":["minpos"],"robots":[2],"radios":[{"range_m":5.0}],"repetitions":1,"base":{"x":1.0,"y":1.0},"stop":{"max_time_s":60.0},"reference":"informed"}');
INSERT INTO "meta" VALUES('folder','/maps');
INSERT INTO "meta" VALUES('provenance','{"versions": {}, "program": "p", "machine": "\u001b[2J", "system": "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"}');
CREATE TABLE plans (
    run TEXT PRIMARY KEY,
    reference TEXT,
    reason TEXT NOT NULL
) WITHOUT ROWID
;
INSERT INTO "plans" VALUES('aa5076ad3e09d7c38f02f67275e25f5a','{"time_to_90_s":12.5,"time_to_95_s":12.5,"time_to_99_s":12.5,"makespan_s":12.5,"distance_m":12.5,"coverage":12.5}','');
CREATE TABLE runs (
    key TEXT PRIMARY KEY,
    position INTEGER NOT NULL,
    environment TEXT NOT NULL,
    strategy TEXT NOT NULL,
    robots INTEGER NOT NULL,
    team TEXT NOT NULL,
    starts TEXT NOT NULL,
    radio TEXT NOT NULL,
    body TEXT NOT NULL,
    faults TEXT NOT NULL,
    repetition INTEGER NOT NULL,
    status TEXT NOT NULL,
    reason TEXT NOT NULL,
    digest TEXT NOT NULL,
    metrics TEXT,
    horizon_s REAL,
    chance INTEGER NOT NULL,
    same_as INTEGER,
    covered_at_s TEXT NOT NULL,
    computing_s REAL NOT NULL,
    wall_s REAL NOT NULL,
    memory_mb REAL NOT NULL
);
INSERT INTO "runs" VALUES('aa5076ad3e09d7c38f02f67275e25f5a',0,'open','minpos',2,'','scattered','5 m','disc:0.25','none',0,'complete','all robots: no frontier is left that it can reach','df9f7d376583c9b2a3ee69e3a422e73c57b93a271d2746404f376761b7c98b24','{"outcome":"complete","known_complete_s":4.0,"makespan_s":5.0,"total_distance_m":2.6749945417800713,"distance_by_robot_m":[1.5027492444221169,1.1722452973579545],"distance_spread_m":0.1652519735320812,"waiting_time_s":0.0,"waiting_time_by_robot_s":[0.0,0.0],"coverage":1.0,"seen":1.0,"coverage_integral_s":0.22887505357258542,"free_area_m2":36.0,"explorable_area_m2":35.99999999999986,"covered_area_m2":35.99999999999986,"seen_area_m2":35.99999999999986,"unseen_m2":0.0,"given_up_m2":{},"overlap_area_m2":15.398769318431176,"overlap_share":0.4277435921786455,"lost_area_m2":0.0,"lost_area_by_robot_m2":[0.0,0.0],"isolated_total_s":0.0,"isolated_by_robot_s":[0.0,0.0],"isolated_longest_s":0.0,"beyond_range_m":0.0,"split_s":0.0,"known_to_one_m2s":0.0,"known_to_one_by_robot_m2s":[0.0,0.0],"known_to_one_m2":0.0,"time_to_90_s":0.0,"time_to_95_s":3.0,"time_to_99_s":4.0,"nodes":9,"nodes_by_robot":[5,4],"nodes_by_stage":{"root":2,"scan":7},"decisions":0,"coordinations":0,"deadlocks":0,"protective_stops":0,"deaths":0,"messages":35,"deliveries":56,"lost_deliveries":0,"bytes_sent":9845,"messages_by_kind":{"acknowledgement":12,"report":23},"bytes_by_kind":{"acknowledgement":272,"report":9573},"arcs_closed":{},"frontier_left_m":0.0,"collisions":0,"min_clearance_m":0.28876754353828993,"min_distance_between_robots_m":4.241530547578823,"lower_bound_s":1.5945776915180492,"lower_bound_reach_s":1.5945776915180492,"lower_bound_area_s":0.36040185516270373,"lower_bound_witness_s":null,"diagram_left":{},"bids_by_radius":{},"delivered_coverage":1.0,"delivered_90_s":0.0,"delivered_95_s":3.0,"delivered_99_s":4.0,"base_age_s":1.809663530138984e-14,"carrying_s":0.0}',NULL,1,NULL,'{"covered":[0.0,0.0,0.0,0.0,0.0,4.0],"delivered":[0.0,0.0,0.0,0.0,0.0,4.0]}',0.5,0.5,100.0);
COMMIT;
