-- SPDX-License-Identifier: Apache-2.0
-- The store of a site: what its rigs recorded, and the functions that are the one door for them (docs/decisions/0031).
--
-- The record stays a rig's own SQLite file. What is here is a copy that many may ask, made of the same numbers; a run's
-- rows come in order and without holes, so that "how far is it?" has one answer: run.last_slot.
--
-- No clock of the server is in any key. A run is filed under the month in which its own clock says that it started.
--
-- sample.numbers has a number for each channel of the run, in order of their positions. What is missing is NULL inside
-- the array and not NaN: avg() and max() pass over it instead of becoming NaN, it costs a bit instead of eight bytes,
-- and two rows that miss the same reading are equal. Whole numbers, as nanoseconds are, are exact up to 2^53, which is
-- 104 days; of a word (phase, state) there is the place in channel.words, from 0.
--
-- Who is who: the role that migrates owns all this and is the only one that may change or delete. Members of
-- gyrotherm_rig call functions and see no table. Members of gyrotherm_analyst read. A run belongs to the role that
-- logged in to add it (session_user, which SET ROLE does not change), and a rig's name to the first role that used it.

DO $$
BEGIN
  IF NOT EXISTS (SELECT FROM pg_roles WHERE rolname = 'gyrotherm_rig') THEN
    CREATE ROLE gyrotherm_rig NOLOGIN;
  END IF;
  IF NOT EXISTS (SELECT FROM pg_roles WHERE rolname = 'gyrotherm_analyst') THEN
    CREATE ROLE gyrotherm_analyst NOLOGIN;
  END IF;
END
$$;

REVOKE ALL ON SCHEMA gyrotherm FROM PUBLIC;
GRANT USAGE ON SCHEMA gyrotherm TO gyrotherm_rig, gyrotherm_analyst;
ALTER DEFAULT PRIVILEGES IN SCHEMA gyrotherm GRANT SELECT ON TABLES TO gyrotherm_analyst;
ALTER DEFAULT PRIVILEGES REVOKE EXECUTE ON FUNCTIONS FROM PUBLIC;
GRANT SELECT ON gyrotherm.migration TO gyrotherm_analyst;

-- Tables

CREATE TABLE gyrotherm.rig (
  name text PRIMARY KEY CHECK (name ~ '^[^[:cntrl:]]{1,64}$'),
  owner name NOT NULL
);

CREATE TABLE gyrotherm.unit (
  serial_number text NOT NULL CHECK (serial_number <> ''),
  model text NOT NULL,
  PRIMARY KEY (serial_number, model)
);

CREATE TABLE gyrotherm.run (
  id uuid PRIMARY KEY,
  rig text NOT NULL REFERENCES gyrotherm.rig,
  owner name NOT NULL,
  started timestamptz NOT NULL,
  profile text NOT NULL,
  simulated boolean NOT NULL,
  imported boolean NOT NULL,
  info jsonb NOT NULL,
  -- What it is doing, as its rig said last.
  state text NOT NULL DEFAULT 'execute',
  cause text NOT NULL DEFAULT '',
  -- How far it is here: grows with its rows, in the same transaction.
  rows bigint NOT NULL DEFAULT 0,
  last_slot integer NOT NULL DEFAULT -1,
  last_utc_ns bigint,
  events bigint NOT NULL DEFAULT 0,
  last_event bigint NOT NULL DEFAULT 0,
  gaps bigint NOT NULL DEFAULT 0,
  last_gap integer NOT NULL DEFAULT -1,
  -- Of a finished run.
  finished boolean NOT NULL DEFAULT false,
  ended timestamptz,
  chain_head text,
  files jsonb,           -- [{"name", "sha256", "bytes"}], the record's own first
  rows_in_record bigint, -- fewer than here where a rig lost the end of a record that had been sent already
  -- The owner dropped its samples.
  dropped boolean NOT NULL DEFAULT false,
  UNIQUE (id, started)
) WITH (fillfactor = 50);
CREATE INDEX ON gyrotherm.run (rig, started);
CREATE INDEX ON gyrotherm.run (started);

CREATE TABLE gyrotherm.channel (
  run uuid NOT NULL REFERENCES gyrotherm.run,
  position smallint NOT NULL, -- in sample.numbers, from 1
  name text NOT NULL,
  unit text NOT NULL,
  measures text NOT NULL,
  unit_under_test text NOT NULL, -- label of it in the run; empty: the rig's
  words text[],                  -- what a number of it stands for; NULL where it is a number
  calibration jsonb,             -- of a thermometer: offset, polynomial, certificate, due, uncertainty
  PRIMARY KEY (run, position)
);

CREATE TABLE gyrotherm.run_unit (
  run uuid NOT NULL REFERENCES gyrotherm.run,
  label text NOT NULL,
  serial_number text NOT NULL,
  model text NOT NULL,
  PRIMARY KEY (run, label),
  FOREIGN KEY (serial_number, model) REFERENCES gyrotherm.unit
);
CREATE INDEX ON gyrotherm.run_unit (serial_number);

CREATE TABLE gyrotherm.thermometer (
  rig text NOT NULL REFERENCES gyrotherm.rig,
  name text NOT NULL,
  instrument text NOT NULL,
  certificate text NOT NULL,
  calibrated date,
  due date,
  run uuid NOT NULL REFERENCES gyrotherm.run, -- the latest that had it
  started timestamptz NOT NULL,
  PRIMARY KEY (rig, name)
);

CREATE TABLE gyrotherm.event (
  run uuid NOT NULL REFERENCES gyrotherm.run,
  number bigint NOT NULL,
  slot integer NOT NULL,
  utc_ns bigint NOT NULL,
  kind text NOT NULL,
  interlock text,
  reaction text,
  segment integer,
  channel text,
  text text NOT NULL,
  PRIMARY KEY (run, number)
);

CREATE TABLE gyrotherm.gap (
  run uuid NOT NULL REFERENCES gyrotherm.run,
  first integer NOT NULL,
  last integer NOT NULL CHECK (last >= first),
  cause text NOT NULL,
  PRIMARY KEY (run, first)
);

-- The month of `started` is the partition, so that a month is dropped at once; (run, started) is one run, so that
-- (run, slot) is one row although partitions go by time.
CREATE TABLE gyrotherm.sample (
  started timestamptz NOT NULL,
  run uuid NOT NULL,
  slot integer NOT NULL,
  utc_ns bigint,
  numbers double precision[] NOT NULL,
  PRIMARY KEY (started, run, slot),
  FOREIGN KEY (run, started) REFERENCES gyrotherm.run (id, started)
) PARTITION BY RANGE (started);

-- What is left of samples that were dropped: of each hour and channel how many numbers there were, their mean, and the
-- lowest and the highest of them.
CREATE TABLE gyrotherm.sample_hour (
  run uuid NOT NULL REFERENCES gyrotherm.run,
  hour integer NOT NULL, -- since the run started, from 0
  position smallint NOT NULL,
  numbers integer NOT NULL,
  mean double precision NOT NULL,
  lowest double precision NOT NULL,
  highest double precision NOT NULL,
  PRIMARY KEY (run, hour, position)
);

-- A model, a report, a certificate, to the byte: sha256 is that of the text in UTF-8.
CREATE TABLE gyrotherm.document (
  sha256 text PRIMARY KEY,
  kind text NOT NULL, -- calibration, model, report
  schema text NOT NULL,
  name text NOT NULL, -- of the file
  rig text NOT NULL REFERENCES gyrotherm.rig,
  owner name NOT NULL,
  text text NOT NULL
);

-- What a calibration report says, taken from its document by the store itself.
CREATE TABLE gyrotherm.calibration (
  sha256 text PRIMARY KEY REFERENCES gyrotherm.document,
  serial_number text NOT NULL,
  model text NOT NULL,
  number text NOT NULL,
  state text NOT NULL, -- draft, authorised, superseded
  simulated boolean NOT NULL,
  calibrated date NOT NULL, -- the day on which its last record ended
  issued date,
  FOREIGN KEY (serial_number, model) REFERENCES gyrotherm.unit
);
CREATE INDEX ON gyrotherm.calibration (serial_number, calibrated);

CREATE TABLE gyrotherm.calibration_result (
  sha256 text NOT NULL REFERENCES gyrotherm.calibration,
  number integer NOT NULL,
  axis text NOT NULL,
  stage text NOT NULL, -- uncompensated, as_found, as_left
  quantity text NOT NULL, -- KEY.QUANTITY, as docs/calibration-report.md has them
  condition text NOT NULL, -- profile, detail and what else stands in the line of its table
  value double precision,
  standard_uncertainty double precision,
  expanded_uncertainty double precision,
  unit text NOT NULL,
  in_sample boolean NOT NULL,
  PRIMARY KEY (sha256, number)
);
CREATE INDEX ON gyrotherm.calibration_result (quantity, stage);

-- Nanoseconds since 1970 as the store's kind of time, to the microsecond.
CREATE FUNCTION gyrotherm.utc(ns bigint) RETURNS timestamptz LANGUAGE sql IMMUTABLE PARALLEL SAFE
RETURN 'epoch'::timestamptz + ns / 1000 * interval '1 microsecond';

-- Functions of the owner's alone

-- Makes the partition of a month where there is none. It is made beside the table and attached, so that writers of
-- other months wait for a moment only.
CREATE FUNCTION gyrotherm.make_month(a_month timestamptz) RETURNS void
LANGUAGE plpgsql SET search_path = pg_catalog, pg_temp SET timezone = 'UTC' AS $$
DECLARE
  first timestamptz := date_trunc('month', a_month);
  following timestamptz := first + interval '1 month';
  partition text := 'sample_' || to_char(first, 'YYYY_MM');
BEGIN
  IF to_regclass('gyrotherm.' || partition) IS NOT NULL THEN RETURN; END IF;
  PERFORM pg_advisory_xact_lock(hashtext('gyrotherm.make_month'));
  -- Whoever waited for another one that made it would not see it by its name yet, but does so in the catalogue.
  IF EXISTS (SELECT FROM pg_class WHERE relnamespace = 'gyrotherm'::regnamespace AND relname = partition) THEN
    RETURN;
  END IF;
  EXECUTE format('CREATE TABLE gyrotherm.%I (LIKE gyrotherm.sample INCLUDING DEFAULTS, '
                 'CHECK (started >= %L AND started < %L))', partition, first, following);
  EXECUTE format('ALTER TABLE gyrotherm.sample ATTACH PARTITION gyrotherm.%I FOR VALUES FROM (%L) TO (%L)',
                 partition, first, following);
END
$$;

-- Retention: drops the samples of the runs that started in a month, all of them finished; what they were, means of each
-- hour, their events and their calibrations stay. Returns how many runs that were. With `detach` the partition is kept as a table beside,
-- gyrotherm.dropped_YYYY_MM, for pg_dump.
CREATE FUNCTION gyrotherm.drop_month(a_month date, detach boolean DEFAULT false) RETURNS bigint
LANGUAGE plpgsql SET search_path = pg_catalog, pg_temp SET timezone = 'UTC' AS $$
DECLARE
  first timestamptz := date_trunc('month', a_month::timestamptz);
  following timestamptz := first + interval '1 month';
  partition text := 'sample_' || to_char(first, 'YYYY_MM');
  runs bigint;
BEGIN
  IF to_regclass('gyrotherm.' || partition) IS NULL THEN RETURN 0; END IF;
  PERFORM FROM gyrotherm.run WHERE started >= first AND started < following ORDER BY id FOR UPDATE;
  IF EXISTS (SELECT FROM gyrotherm.run
             WHERE started >= first AND started < following AND NOT finished AND NOT dropped) THEN
    RAISE EXCEPTION 'a run that started in this month is not finished' USING ERRCODE = '55000',
      HINT = 'see gyrotherm.v1_attention; gyrotherm.give_up(run) takes one for ended that nobody will finish';
  END IF;
  INSERT INTO gyrotherm.sample_hour
    SELECT s.run, s.slot / 3600, n.position, count(*), avg(n.value), min(n.value), max(n.value)
    FROM gyrotherm.sample s
    CROSS JOIN LATERAL unnest(s.numbers) WITH ORDINALITY AS n(value, position)
    WHERE s.started >= first AND s.started < following AND n.value IS NOT NULL
    GROUP BY s.run, s.slot / 3600, n.position
    ON CONFLICT DO NOTHING;
  UPDATE gyrotherm.run SET dropped = true WHERE started >= first AND started < following;
  GET DIAGNOSTICS runs = ROW_COUNT;
  EXECUTE format('ALTER TABLE gyrotherm.sample DETACH PARTITION gyrotherm.%I', partition);
  IF detach THEN
    EXECUTE format('ALTER TABLE gyrotherm.%I RENAME TO %I', partition, 'dropped_' || to_char(first, 'YYYY_MM'));
  ELSE
    EXECUTE format('DROP TABLE gyrotherm.%I', partition);
  END IF;
  RETURN runs;
END
$$;

-- Takes a run for ended of which no rig will send the rest: it takes no more rows.
CREATE FUNCTION gyrotherm.give_up(a_run uuid) RETURNS void
LANGUAGE sql SET search_path = pg_catalog, pg_temp AS $$
  UPDATE gyrotherm.run SET finished = true, state = 'given up', rows_in_record = rows
  WHERE id = a_run AND NOT finished;
$$;

-- Functions for rigs

CREATE FUNCTION gyrotherm.refuse(why text) RETURNS double precision[]
LANGUAGE plpgsql SET search_path = pg_catalog, pg_temp AS $$
BEGIN
  RAISE EXCEPTION '%', why USING ERRCODE = '22023';
END
$$;

-- The run, locked until the transaction ends, if it is the caller's. Whether there is such a run of somebody else's is
-- not told.
CREATE FUNCTION gyrotherm.own_run(a_run uuid) RETURNS gyrotherm.run
LANGUAGE plpgsql SET search_path = pg_catalog, pg_temp AS $$
DECLARE
  found_run gyrotherm.run;
BEGIN
  SELECT * INTO found_run FROM gyrotherm.run WHERE id = a_run AND owner = session_user FOR NO KEY UPDATE;
  IF NOT FOUND THEN
    RAISE EXCEPTION 'run % is not one of %', a_run, session_user USING ERRCODE = '42501';
  END IF;
  RETURN found_run;
END
$$;

-- The rig of that name, which belongs to the caller from now on if it was nobody's.
CREATE FUNCTION gyrotherm.own_rig(a_rig text) RETURNS void
LANGUAGE plpgsql SET search_path = pg_catalog, pg_temp AS $$
BEGIN
  INSERT INTO gyrotherm.rig(name, owner) VALUES (a_rig, session_user) ON CONFLICT DO NOTHING;
  PERFORM FROM gyrotherm.rig WHERE name = a_rig AND owner = session_user;
  IF NOT FOUND THEN
    RAISE EXCEPTION 'rig "%" is not one of %', a_rig, session_user USING ERRCODE = '42501';
  END IF;
END
$$;

-- The number of the last migration.
CREATE FUNCTION gyrotherm.version() RETURNS integer
LANGUAGE sql STABLE SECURITY DEFINER SET search_path = pg_catalog, pg_temp AS $$
  SELECT max(number) FROM gyrotherm.migration;
$$;

-- How far a run of the caller's is; no row if there is none.
CREATE FUNCTION gyrotherm.run_position(a_run uuid)
RETURNS TABLE (last_slot integer, last_event bigint, last_gap integer, state text, cause text, finished boolean,
               dropped boolean)
LANGUAGE sql STABLE SECURITY DEFINER SET search_path = pg_catalog, pg_temp AS $$
  SELECT r.last_slot, r.last_event, r.last_gap, r.state, r.cause, r.finished, r.dropped
  FROM gyrotherm.run r WHERE r.id = a_run AND r.owner = session_user;
$$;

-- A run with its channels: {"started_ns", "profile", "simulated", "imported", "channels": [{"name", "unit", "measures",
-- "unit_under_test", "words", "calibration"}], "units": [{"label", "serial_number", "model"}], …}; all of it is kept
-- as run.info but the channels. The same run again changes nothing; one that differs is refused.
CREATE FUNCTION gyrotherm.add_run(a_run uuid, a_rig text, a_info jsonb) RETURNS void
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp SET timezone = 'UTC' AS $$
DECLARE
  begun timestamptz := gyrotherm.utc((a_info->>'started_ns')::bigint);
  kept jsonb := a_info - 'channels';
  there gyrotherm.run;
  is_new boolean := false;
BEGIN
  IF begun IS NULL OR begun < 'epoch' OR begun >= '2117-01-01' THEN
    PERFORM gyrotherm.refuse('no run starts then');
  END IF;
  IF NOT EXISTS (SELECT FROM gyrotherm.run WHERE id = a_run) THEN
    PERFORM gyrotherm.own_rig(a_rig);
    PERFORM gyrotherm.make_month(begun);
    INSERT INTO gyrotherm.run(id, rig, owner, started, profile, simulated, imported, info)
    VALUES (a_run, a_rig, session_user, begun, a_info->>'profile', (a_info->>'simulated')::boolean,
            (a_info->>'imported')::boolean, kept)
    ON CONFLICT DO NOTHING;
    is_new := FOUND;
  END IF;
  IF NOT is_new THEN -- or somebody was faster
    there := gyrotherm.own_run(a_run);
    IF there.info <> kept OR there.rig <> a_rig THEN
      PERFORM gyrotherm.refuse('the run that is there is another one');
    END IF;
    RETURN;
  END IF;
  INSERT INTO gyrotherm.channel(run, position, name, unit, measures, unit_under_test, words, calibration)
  SELECT a_run, c.position, c.value->>'name', c.value->>'unit', c.value->>'measures', c.value->>'unit_under_test',
         CASE WHEN c.value ? 'words' THEN ARRAY(SELECT jsonb_array_elements_text(c.value->'words')) END,
         c.value->'calibration'
  FROM jsonb_array_elements(a_info->'channels') WITH ORDINALITY AS c(value, position);
  INSERT INTO gyrotherm.unit(serial_number, model)
  SELECT DISTINCT u->>'serial_number', u->>'model' FROM jsonb_array_elements(a_info->'units') u
  WHERE u->>'serial_number' <> '' ON CONFLICT DO NOTHING;
  INSERT INTO gyrotherm.run_unit(run, label, serial_number, model)
  SELECT a_run, u->>'label', u->>'serial_number', u->>'model' FROM jsonb_array_elements(a_info->'units') u
  WHERE u->>'serial_number' <> '';
  INSERT INTO gyrotherm.thermometer(rig, name, instrument, certificate, calibrated, due, run, started)
  SELECT a_rig, c->>'name', c->'calibration'->>'instrument', c->'calibration'->>'certificate',
         nullif(c->'calibration'->>'calibrated', '')::date, nullif(c->'calibration'->>'due', '')::date, a_run, begun
  FROM jsonb_array_elements(a_info->'channels') c WHERE c->>'measures' = 'temperature' AND c ? 'calibration'
  ON CONFLICT (rig, name) DO UPDATE SET instrument = EXCLUDED.instrument, certificate = EXCLUDED.certificate,
    calibrated = EXCLUDED.calibrated, due = EXCLUDED.due, run = EXCLUDED.run, started = EXCLUDED.started
  WHERE gyrotherm.thermometer.started < EXCLUDED.started;
END
$$;

-- Rows, the first and the last slot at their ends, the next ones behind slot `after`, which must not lie behind the
-- last that is there: so rows have no holes. Each of `numbers` is an array as text, "{1.5,NULL}", with a number for
-- each channel. Rows that are there already must be the same; then nothing changes. Returns the run's last slot.
CREATE FUNCTION gyrotherm.add_rows(a_run uuid, a_after integer, slots integer[], utcs bigint[], numbers text[])
RETURNS integer
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp AS $$
DECLARE
  to_run gyrotherm.run := gyrotherm.own_run(a_run);
  channels integer := (SELECT count(*) FROM gyrotherm.channel WHERE run = a_run);
  added integer;
  last_one integer := slots[cardinality(slots)];
BEGIN
  IF cardinality(slots) = 0 THEN RETURN to_run.last_slot; END IF;
  IF to_run.dropped THEN PERFORM gyrotherm.refuse('the samples of this run were dropped'); END IF;
  IF a_after > to_run.last_slot THEN
    PERFORM gyrotherm.refuse(format('rows behind slot %s would leave a hole behind slot %s', a_after,
                                    to_run.last_slot));
  END IF;
  IF cardinality(slots) <> cardinality(utcs) OR cardinality(slots) <> cardinality(numbers)
     OR slots[1] <= a_after OR slots[1] < 0 OR last_one > 100000000
     OR (SELECT min(s) <> slots[1] OR max(s) <> last_one OR count(DISTINCT s) <> count(*)
         FROM unnest(slots) AS u(s)) THEN
    PERFORM gyrotherm.refuse('the rows are not in order');
  END IF;
  IF to_run.finished AND last_one > to_run.last_slot THEN PERFORM gyrotherm.refuse('the run is finished'); END IF;
  INSERT INTO gyrotherm.sample(started, run, slot, utc_ns, numbers)
  SELECT to_run.started, a_run, u.slot, u.utc_ns,
         CASE WHEN array_ndims(u.row) = 1 AND array_lower(u.row, 1) = 1 AND cardinality(u.row) = channels THEN u.row
              ELSE gyrotherm.refuse(format('a row has not %s numbers', channels)) END
  FROM (SELECT t.slot, t.utc_ns, t.row::double precision[] FROM unnest(slots, utcs, numbers) AS t(slot, utc_ns, row)
        OFFSET 0) AS u(slot, utc_ns, row) -- a text is read once
  ON CONFLICT DO NOTHING;
  GET DIAGNOSTICS added = ROW_COUNT;
  IF added < cardinality(slots) THEN
    IF EXISTS (
      SELECT FROM unnest(slots, utcs, numbers) AS u(slot, utc_ns, row)
      CROSS JOIN LATERAL ( -- each by its key, whatever statistics say: a whole run would be read otherwise
        SELECT t.utc_ns, t.numbers FROM gyrotherm.sample t
        WHERE t.started = to_run.started AND t.run = a_run AND t.slot = u.slot OFFSET 0) s
      WHERE s.utc_ns IS DISTINCT FROM u.utc_ns OR s.numbers <> u.row::double precision[]
    ) THEN
      PERFORM gyrotherm.refuse('a row that is there is another one');
    END IF;
  END IF;
  IF added > 0 THEN
    UPDATE gyrotherm.run SET rows = rows + added, last_slot = greatest(last_slot, last_one),
      last_utc_ns = CASE WHEN last_one > last_slot THEN utcs[cardinality(utcs)] ELSE last_utc_ns END
    WHERE id = a_run;
  END IF;
  RETURN greatest(to_run.last_slot, last_one);
END
$$;

-- Events in order of their numbers, the next ones behind number `after`: [{"number", "slot", "utc_ns", "kind",
-- "interlock", "reaction", "segment", "channel", "text"}]. Otherwise as add_rows.
CREATE FUNCTION gyrotherm.add_events(a_run uuid, a_after bigint, a_events jsonb) RETURNS bigint
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp AS $$
DECLARE
  to_run gyrotherm.run := gyrotherm.own_run(a_run);
  added integer;
  last_one bigint := (SELECT max((e->>'number')::bigint) FROM jsonb_array_elements(a_events) e);
BEGIN
  IF last_one IS NULL THEN RETURN to_run.last_event; END IF;
  IF a_after > to_run.last_event THEN PERFORM gyrotherm.refuse('these events would leave a hole'); END IF;
  IF (SELECT min((e->>'number')::bigint) FROM jsonb_array_elements(a_events) e) <= a_after THEN
    PERFORM gyrotherm.refuse('the events are not in order');
  END IF;
  IF to_run.finished AND last_one > to_run.last_event THEN PERFORM gyrotherm.refuse('the run is finished'); END IF;
  INSERT INTO gyrotherm.event(run, number, slot, utc_ns, kind, interlock, reaction, segment, channel, text)
  SELECT a_run, e.* FROM jsonb_to_recordset(a_events) AS e(number bigint, slot integer, utc_ns bigint, kind text,
    interlock text, reaction text, segment integer, channel text, text text)
  ON CONFLICT DO NOTHING;
  GET DIAGNOSTICS added = ROW_COUNT;
  IF added < jsonb_array_length(a_events) AND EXISTS (
    SELECT FROM jsonb_to_recordset(a_events) AS e(number bigint, slot integer, utc_ns bigint, kind text, interlock text,
      reaction text, segment integer, channel text, text text)
    JOIN gyrotherm.event s ON s.run = a_run AND s.number = e.number
    WHERE (s.slot, s.utc_ns, s.kind, s.interlock, s.reaction, s.segment, s.channel, s.text)
      IS DISTINCT FROM (e.slot, e.utc_ns, e.kind, e.interlock, e.reaction, e.segment, e.channel, e.text)
  ) THEN
    PERFORM gyrotherm.refuse('an event that is there is another one');
  END IF;
  UPDATE gyrotherm.run SET events = events + added, last_event = greatest(last_event, last_one)
  WHERE id = a_run AND added > 0;
  RETURN greatest(to_run.last_event, last_one);
END
$$;

-- Gaps in order, the next ones behind the gap that begins with slot `after`: [{"first", "last", "cause"}]. Otherwise as
-- add_rows.
CREATE FUNCTION gyrotherm.add_gaps(a_run uuid, a_after integer, a_gaps jsonb) RETURNS integer
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp AS $$
DECLARE
  to_run gyrotherm.run := gyrotherm.own_run(a_run);
  added integer;
  last_one integer := (SELECT max((g->>'first')::integer) FROM jsonb_array_elements(a_gaps) g);
BEGIN
  IF last_one IS NULL THEN RETURN to_run.last_gap; END IF;
  IF a_after > to_run.last_gap THEN PERFORM gyrotherm.refuse('these gaps would leave a hole'); END IF;
  IF (SELECT min((g->>'first')::integer) FROM jsonb_array_elements(a_gaps) g) <= a_after THEN
    PERFORM gyrotherm.refuse('the gaps are not in order');
  END IF;
  IF to_run.finished AND last_one > to_run.last_gap THEN PERFORM gyrotherm.refuse('the run is finished'); END IF;
  INSERT INTO gyrotherm.gap(run, first, last, cause)
  SELECT a_run, g.* FROM jsonb_to_recordset(a_gaps) AS g(first integer, last integer, cause text)
  ON CONFLICT DO NOTHING;
  GET DIAGNOSTICS added = ROW_COUNT;
  IF added < jsonb_array_length(a_gaps) AND EXISTS (
    SELECT FROM jsonb_to_recordset(a_gaps) AS g(first integer, last integer, cause text)
    JOIN gyrotherm.gap s ON s.run = a_run AND s.first = g.first
    WHERE (s.last, s.cause) IS DISTINCT FROM (g.last, g.cause)
  ) THEN
    PERFORM gyrotherm.refuse('a gap that is there is another one');
  END IF;
  UPDATE gyrotherm.run SET gaps = gaps + added, last_gap = greatest(last_gap, last_one)
  WHERE id = a_run AND added > 0;
  RETURN greatest(to_run.last_gap, last_one);
END
$$;

-- What an unfinished run does now, and why.
CREATE FUNCTION gyrotherm.say_state(a_run uuid, a_state text, a_cause text) RETURNS void
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp AS $$
DECLARE
  to_run gyrotherm.run := gyrotherm.own_run(a_run);
BEGIN
  UPDATE gyrotherm.run SET state = a_state, cause = a_cause
  WHERE id = a_run AND NOT finished AND (state, cause) IS DISTINCT FROM (a_state, a_cause);
END
$$;

-- The end of a run: {"state", "cause", "ended_ns", "rows", "events", "gaps", "chain_head", "files"}. It is refused as
-- long as the store has fewer rows, events or gaps than the record. The same again changes nothing.
CREATE FUNCTION gyrotherm.finish_run(a_run uuid, a_end jsonb) RETURNS void
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp AS $$
DECLARE
  to_run gyrotherm.run := gyrotherm.own_run(a_run);
BEGIN
  IF to_run.finished THEN
    IF (to_run.chain_head, to_run.files) IS DISTINCT FROM (a_end->>'chain_head', a_end->'files') THEN
      PERFORM gyrotherm.refuse('the run is finished, with other files');
    END IF;
    RETURN;
  END IF;
  IF to_run.rows < (a_end->>'rows')::bigint OR to_run.events < (a_end->>'events')::bigint
     OR to_run.gaps < (a_end->>'gaps')::bigint THEN
    PERFORM gyrotherm.refuse(format('the store has %s rows, %s events and %s gaps, the record %s, %s and %s',
      to_run.rows, to_run.events, to_run.gaps, a_end->>'rows', a_end->>'events', a_end->>'gaps'));
  END IF;
  UPDATE gyrotherm.run SET finished = true, state = a_end->>'state', cause = a_end->>'cause',
    ended = gyrotherm.utc((a_end->>'ended_ns')::bigint),
    chain_head = a_end->>'chain_head', files = a_end->'files', rows_in_record = (a_end->>'rows')::bigint
  WHERE id = a_run;
END
$$;

-- Whether a document is there already.
CREATE FUNCTION gyrotherm.has_document(a_sha256 text) RETURNS boolean
LANGUAGE sql STABLE SECURITY DEFINER SET search_path = pg_catalog, pg_temp AS $$
  SELECT EXISTS (SELECT FROM gyrotherm.document WHERE sha256 = a_sha256);
$$;

-- A model, report or calibration. It is known by its own bytes: what a calibration says is taken from them here, so
-- that nobody can say it otherwise. Returns its SHA-256.
CREATE FUNCTION gyrotherm.add_document(a_rig text, a_kind text, a_name text, a_text text) RETURNS text
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp AS $$
DECLARE
  digest text := encode(sha256(convert_to(a_text, 'UTF8')), 'hex');
  d jsonb := a_text::jsonb;
BEGIN
  PERFORM gyrotherm.own_rig(a_rig);
  IF a_kind NOT IN ('calibration', 'model', 'report') OR d->>'schema' NOT LIKE 'gyrotherm-' || a_kind || '/%' THEN
    PERFORM gyrotherm.refuse('it is no such document');
  END IF;
  INSERT INTO gyrotherm.document(sha256, kind, schema, name, rig, owner, text)
  VALUES (digest, a_kind, d->>'schema', a_name, a_rig, session_user, a_text) ON CONFLICT DO NOTHING;
  IF NOT FOUND OR a_kind <> 'calibration' OR d->'item'->>'serial_number' = ''
     OR coalesce(d->>'ended', '') = '' THEN
    RETURN digest;
  END IF;
  INSERT INTO gyrotherm.unit(serial_number, model) VALUES (d->'item'->>'serial_number', d->'item'->>'model')
  ON CONFLICT DO NOTHING;
  INSERT INTO gyrotherm.calibration(sha256, serial_number, model, number, state, simulated, calibrated, issued)
  VALUES (digest, d->'item'->>'serial_number', d->'item'->>'model', d->>'number', d->>'state',
          (d->>'simulated')::boolean, (d->>'ended')::date, nullif(d->>'issued', '')::date);
  INSERT INTO gyrotherm.calibration_result(sha256, number, axis, stage, quantity, condition, value,
    standard_uncertainty, expanded_uncertainty, unit, in_sample)
  SELECT digest, number, axis, stage, quantity,
    concat_ws(', ', condition, CASE WHEN again > 1 THEN 'again ' || again END), value, u, expanded, unit, in_sample
  FROM (
    SELECT *, row_number() OVER (PARTITION BY axis, stage, quantity, condition ORDER BY number) AS again FROM (
      SELECT row_number() OVER (ORDER BY r.n, c.n, v.n) AS number, r.value->>'axis' AS axis, r.value->>'stage' AS stage,
        (r.value->>'key') || '.' || (c.value->>'quantity') AS quantity,
        concat_ws(', ',
          (SELECT f->>'profile' FROM jsonb_array_elements(d->'files') f
           WHERE f->>'role' = 'record' AND f->>'id' = r.value->>'run' LIMIT 1),
          nullif(r.value->>'detail', ''),
          -- A table's first column, where it has no uncertainty, says of what the others are: a set point, a share.
          (SELECT string_agg(format('%s %s %s', replace(o.value->>'quantity', '_', ' '),
                                    o.value->'values'->(v.n::integer - 1)->>'value', o.value->>'unit'), ', '
                             ORDER BY o.n)
           FROM jsonb_array_elements(r.value->'columns') WITH ORDINALITY AS o(value, n)
           WHERE (o.n = 1 AND NOT o.value->'values'->(v.n::integer - 1) ? 'U' OR o.value->>'quantity' = 'within')
             AND o.n <> c.n)) AS condition,
        (v.value->>'value')::double precision AS value, (v.value->>'u')::double precision AS u,
        (v.value->>'U')::double precision AS expanded, c.value->>'unit' AS unit,
        (r.value->>'in_sample')::boolean AS in_sample
      FROM jsonb_array_elements(d->'results') WITH ORDINALITY AS r(value, n),
        jsonb_array_elements(r.value->'columns') WITH ORDINALITY AS c(value, n),
        jsonb_array_elements(c.value->'values') WITH ORDINALITY AS v(value, n)
    ) results
  ) numbered;
  RETURN digest;
END
$$;

-- Views for people; what begins with v1 keeps its columns.

CREATE VIEW gyrotherm.v1_run AS
  SELECT id AS run, rig, started, profile, simulated, state, cause, finished, ended, rows, gaps,
         gyrotherm.utc(last_utc_ns) AS last_row, chain_head,
         files->0->>'sha256' AS sha256, (files->0->>'bytes')::bigint AS bytes, dropped
  FROM gyrotherm.run;

CREATE VIEW gyrotherm.v1_channel AS
  SELECT run, position, name, unit, measures, unit_under_test, calibration->>'certificate' AS certificate,
         nullif(calibration->>'due', '')::date AS due
  FROM gyrotherm.channel;

-- As recorded: readings are raw, and channel.calibration says what makes a temperature of them.
CREATE VIEW gyrotherm.v1_sample AS
  SELECT s.run, s.slot, gyrotherm.utc(s.utc_ns) AS utc, c.name, n.value, c.unit,
         c.words[n.value::integer + 1] AS word
  FROM gyrotherm.sample s
  CROSS JOIN LATERAL unnest(s.numbers) WITH ORDINALITY AS n(value, position)
  JOIN gyrotherm.channel c ON c.run = s.run AND c.position = n.position;

CREATE VIEW gyrotherm.v1_hour AS
  SELECT h.run, h.hour, c.name, h.numbers, h.mean, h.lowest, h.highest, c.unit
  FROM gyrotherm.sample_hour h JOIN gyrotherm.channel c ON c.run = h.run AND c.position = h.position
  WHERE c.words IS NULL;

CREATE VIEW gyrotherm.v1_event AS
  SELECT run, number, slot, gyrotherm.utc(utc_ns) AS utc, kind, interlock, reaction, segment,
         channel, text
  FROM gyrotherm.event;

CREATE VIEW gyrotherm.v1_gap AS
  SELECT run, first, last, last - first + 1 AS seconds, cause FROM gyrotherm.gap;

CREATE VIEW gyrotherm.v1_calibration AS
  SELECT c.serial_number, c.model, r.axis, c.calibrated, r.stage, r.quantity, r.condition, r.value,
         r.expanded_uncertainty, r.unit, r.in_sample, c.number, c.state, c.simulated, c.sha256
  FROM gyrotherm.calibration c JOIN gyrotherm.calibration_result r USING (sha256);

-- Rights

REVOKE ALL ON ALL FUNCTIONS IN SCHEMA gyrotherm FROM PUBLIC;
GRANT EXECUTE ON FUNCTION gyrotherm.version(), gyrotherm.utc(bigint) TO gyrotherm_rig, gyrotherm_analyst;
GRANT EXECUTE ON FUNCTION gyrotherm.run_position(uuid), gyrotherm.add_run(uuid, text, jsonb),
  gyrotherm.add_rows(uuid, integer, integer[], bigint[], text[]), gyrotherm.add_events(uuid, bigint, jsonb),
  gyrotherm.add_gaps(uuid, integer, jsonb), gyrotherm.say_state(uuid, text, text), gyrotherm.finish_run(uuid, jsonb),
  gyrotherm.has_document(text), gyrotherm.add_document(text, text, text, text) TO gyrotherm_rig;
GRANT SELECT ON ALL TABLES IN SCHEMA gyrotherm TO gyrotherm_analyst;
