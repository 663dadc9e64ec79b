-- What a look at a machine has found in its history, candidates counted, that its calibration in use cannot know of.
CREATE TABLE standing_finding (
  machine_id BIGINT NOT NULL REFERENCES machine (id),
  position BIGINT NOT NULL,
  kind BIGINT NOT NULL CHECK (kind IN (1, 3, 7)),
  at_utc_us BIGINT NOT NULL,
  text TEXT COLLATE "C" NOT NULL,
  PRIMARY KEY (machine_id, position)
);

-- Nobody has looked for them yet.
UPDATE event_look SET looked_at = 0;
