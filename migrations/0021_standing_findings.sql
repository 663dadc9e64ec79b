-- What a look at a machine has found in its history, candidates counted, that its calibration in use cannot know of.
CREATE TABLE standing_finding (
  machine_id INTEGER NOT NULL REFERENCES machine (id),
  position INTEGER NOT NULL,
  kind INTEGER NOT NULL CHECK (kind IN (1, 3, 7)),
  at_utc_us INTEGER NOT NULL,
  text TEXT NOT NULL,
  PRIMARY KEY (machine_id, position)
) STRICT, WITHOUT ROWID;

-- Nobody has looked for them yet.
UPDATE event_look SET looked_at = 0;
