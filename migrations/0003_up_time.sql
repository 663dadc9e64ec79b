-- How long something waits or was left is counted in the time that a server had the file open: a wall clock may be set.

CREATE TABLE up_time (
  id INTEGER PRIMARY KEY CHECK (id = 1),
  up_us INTEGER NOT NULL CHECK (up_us >= 0)
) STRICT;
INSERT INTO up_time (id, up_us) VALUES (1, 0);

-- What is open begins to be left now.
DROP INDEX session_open;
ALTER TABLE session ADD COLUMN last_seen_up_us INTEGER NOT NULL DEFAULT 0;
CREATE INDEX session_open ON session (last_seen_up_us) WHERE state = 1;

DROP INDEX program_open;
ALTER TABLE program ADD COLUMN last_seen_up_us INTEGER NOT NULL DEFAULT 0;
CREATE INDEX program_open ON program (last_seen_up_us) WHERE state = 1;

-- What waits may be claimed now.
DROP INDEX job_waiting;
ALTER TABLE job DROP COLUMN run_after_utc_us;
ALTER TABLE job ADD COLUMN waits_from_up_us INTEGER NOT NULL DEFAULT 0;
ALTER TABLE job ADD COLUMN wait_us INTEGER NOT NULL DEFAULT 0;
CREATE INDEX job_waiting ON job (priority DESC, id, waits_from_up_us, wait_us) WHERE state = 1;

-- What was given up may be sent again under its request id, and a session by whomever.
DROP INDEX session_by_request;
CREATE INDEX session_by_request ON session (request_id) WHERE request_id IS NOT NULL;
DROP INDEX program_by_request;
CREATE INDEX program_by_request ON program (created_by, request_id) WHERE request_id IS NOT NULL;
