-- oldest program: 22
-- Attempts whose process died with them, of those that `attempt` counts.
ALTER TABLE job ADD COLUMN lost BIGINT NOT NULL DEFAULT 0 CHECK (lost >= 0);

-- When the next one of those has waited that wait for another attempt.
CREATE INDEX job_delayed ON job ((waits_from_up_us + wait_us), id) WHERE state = 1 AND wait_us > 0;
