PRAGMA application_id = 1297302339;
PRAGMA user_version = 1;
BEGIN TRANSACTION;
CREATE TABLE meta (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
INSERT INTO "meta" VALUES('program','@program@');
INSERT INTO "meta" VALUES('provenance','@provenance@');
INSERT INTO "meta" VALUES('seed','7');
CREATE TABLE missions (
    number INTEGER PRIMARY KEY,
    strategy TEXT NOT NULL,
    world TEXT NOT NULL,
    robots INTEGER NOT NULL,
    refused INTEGER NOT NULL,
    outcome TEXT NOT NULL,
    reason TEXT NOT NULL,
    time_s REAL NOT NULL,
    events INTEGER NOT NULL,
    steps INTEGER NOT NULL,
    digest TEXT NOT NULL,
    repeated INTEGER NOT NULL,
    violations TEXT NOT NULL,
    folders TEXT NOT NULL,
    run_s REAL NOT NULL,
    check_s REAL NOT NULL
);
INSERT INTO "missions" VALUES(0,'closest','hall',2,0,'complete','all robots: no frontier is left',12.5,40,60,'fbd6fae9fbd6fae9fbd6fae9fbd6fae9fbd6fae9fbd6fae9fbd6fae9fbd6fae9',0,'[]','[]',0.1,0.2);
INSERT INTO "missions" VALUES(1,'srt-star','hall',2,1,'stalled','all robots: no frontier is left',12.5,40,60,'fbd6fae9fbd6fae9fbd6fae9fbd6fae9fbd6fae9fbd6fae9fbd6fae9fbd6fae9',1,'[{"invariant":"no-collision","says":"robot 0 touched an obstacle at 3.50 s","robot":0,"time_s":3.5}]','["night-failures/000001-no-collision"]',0.1,0.2);
INSERT INTO "missions" VALUES(2,'closest','hall',2,0,'error','all robots: no frontier is left',12.5,40,60,'fbd6fae9fbd6fae9fbd6fae9fbd6fae9fbd6fae9fbd6fae9fbd6fae9fbd6fae9',1,'[{"invariant":"no-error","says":"KeyError in team.py:120: 3","robot":null,"time_s":null}]','["night-failures/000002-no-error"]',0.1,0.2);
COMMIT;
UPDATE missions SET folders = '[]';
