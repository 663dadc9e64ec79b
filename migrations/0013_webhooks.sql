-- Addresses that are told of events, and what could not be brought there (docs/events.md).

CREATE TABLE webhook (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  name TEXT NOT NULL,
  url TEXT NOT NULL,
  secret TEXT NOT NULL,
  scope INTEGER NOT NULL CHECK (scope BETWEEN 1 AND 3),
  scope_name TEXT NOT NULL,
  is_enabled INTEGER NOT NULL CHECK (is_enabled IN (0, 1)),
  note TEXT NOT NULL,
  after_change_id INTEGER NOT NULL,
  tries INTEGER NOT NULL CHECK (tries >= 0),
  next_try_at_utc_us INTEGER,
  last_error TEXT NOT NULL,
  last_sent_at_utc_us INTEGER,
  dead_letters INTEGER NOT NULL CHECK (dead_letters >= 0),
  etag INTEGER NOT NULL CHECK (etag >= 1),
  created_by TEXT NOT NULL,
  created_at_utc_us INTEGER NOT NULL,
  changed_by TEXT NOT NULL,
  changed_at_utc_us INTEGER NOT NULL
) STRICT;
CREATE UNIQUE INDEX webhook_name ON webhook (name);

CREATE TABLE dead_letter (
  webhook_id INTEGER NOT NULL REFERENCES webhook (id),
  change_id INTEGER NOT NULL REFERENCES event_change (id),
  tries INTEGER NOT NULL CHECK (tries >= 1),
  error TEXT NOT NULL,
  at_utc_us INTEGER NOT NULL,
  is_wanted INTEGER NOT NULL CHECK (is_wanted IN (0, 1)),
  PRIMARY KEY (webhook_id, change_id)
) STRICT, WITHOUT ROWID;
CREATE INDEX dead_letter_wanted ON dead_letter (webhook_id, change_id) WHERE is_wanted = 1;
