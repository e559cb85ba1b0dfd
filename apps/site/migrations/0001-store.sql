-- SPDX-License-Identifier: Apache-2.0
-- The store of a site: the runs of its rigs, the functions through which a rig adds to them, and the views that answer
-- questions (docs/decisions/0031, 0045).
--
-- The record remains the SQLite file of the rig. The store has a copy of the same numbers that many programs can read.
-- The rows of a run come in order and without holes, so that run.last_slot alone is the position of a run.
--
-- No key contains a time of the server. A run is filed under the month in which it started by its own clock.
--
-- sample.numbers has one number for each channel of the run, in order of channel.position. A missing number is NULL and
-- not NaN: avg() and max() ignore it, it costs one bit instead of eight bytes, and two rows that miss the same reading
-- are equal. Integers, such as nanoseconds, are exact up to 2^53, which is 104 days. A channel with keywords (phase,
-- state) has their positions in channel.words, from 0.
--
-- Roles: the role that migrates owns everything and is the only one that can change or delete. Members of gyrotherm_rig
-- call functions and read no table. Members of gyrotherm_analyst read. A run belongs to the role that logged in to add
-- it (session_user, which SET ROLE does not change), and the name of a rig to the first role that used it.

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

-- Tables
--
-- A rig is not trusted: its password lies on a computer in a hall. The constraints keep out numbers and days with which
-- a view could not calculate, so that one rig cannot make a view fail for all readers. Two rigs share no row that they
-- insert, because a rig that keeps a transaction open keeps its locks.

CREATE TABLE gyrotherm.rig (
  name text PRIMARY KEY CHECK (name ~ '^[^[:cntrl:]]{1,64}$'),
  owner name NOT NULL
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
  -- The last state that its rig reported.
  state text NOT NULL DEFAULT 'execute',
  cause text NOT NULL DEFAULT '',
  alarms jsonb NOT NULL DEFAULT '[]', -- active or unacknowledged, as in the status file of the run
  -- The position of the run in the store: changes with its rows, in the same transaction.
  rows bigint NOT NULL DEFAULT 0,
  last_slot integer NOT NULL DEFAULT -1,
  last_utc_ns bigint,
  heard timestamptz NOT NULL, -- when the last row came, by the server's clock: for v1_live, not a key
  events bigint NOT NULL DEFAULT 0,
  last_event bigint NOT NULL DEFAULT 0,
  gaps bigint NOT NULL DEFAULT 0,
  last_gap integer NOT NULL DEFAULT -1,
  -- The end of a finished run.
  finished boolean NOT NULL DEFAULT false,
  ended timestamptz,
  chain_head text,
  files jsonb,           -- [{"name", "sha256", "bytes"}], the record first
  rows_in_record bigint, -- fewer than rows if the rig lost the end of a record that was sent before
  -- The owner dropped its samples.
  dropped boolean NOT NULL DEFAULT false,
  UNIQUE (id, started),
  CONSTRAINT run_file_has_a_size CHECK ((files->0->>'bytes')::bigint >= 0)
) WITH (fillfactor = 50);
CREATE INDEX ON gyrotherm.run (rig, simulated, imported, started DESC);
CREATE INDEX ON gyrotherm.run (rig) WHERE NOT finished;
CREATE INDEX ON gyrotherm.run (started);

CREATE TABLE gyrotherm.channel (
  run uuid NOT NULL REFERENCES gyrotherm.run,
  position smallint NOT NULL, -- in sample.numbers, from 1
  name text NOT NULL,
  unit text NOT NULL,
  measures text NOT NULL,
  unit_under_test text NOT NULL, -- its label in the run; empty: the rig's
  words text[],                  -- keywords of its numbers; NULL: plain numbers
  calibration jsonb,             -- thermometer: offset, polynomial, certificate, due, uncertainty
  PRIMARY KEY (run, position),
  CONSTRAINT channel_due_is_a_day CHECK (isfinite(nullif(calibration->>'due', '')::date))
);

CREATE TABLE gyrotherm.run_unit (
  run uuid NOT NULL REFERENCES gyrotherm.run,
  label text NOT NULL,
  serial_number text NOT NULL,
  model text NOT NULL,
  PRIMARY KEY (run, label)
);
CREATE INDEX ON gyrotherm.run_unit (serial_number);

CREATE TABLE gyrotherm.thermometer (
  rig text NOT NULL REFERENCES gyrotherm.rig,
  name text NOT NULL,
  instrument text NOT NULL,
  certificate text NOT NULL,
  calibrated date,
  due date,
  run uuid NOT NULL REFERENCES gyrotherm.run, -- the latest real run with it
  started timestamptz NOT NULL,
  PRIMARY KEY (rig, name),
  CONSTRAINT thermometer_due_is_a_day CHECK (isfinite(calibrated) AND isfinite(due))
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
  PRIMARY KEY (run, first),
  CONSTRAINT gap_lies_in_a_run CHECK (first >= 0 AND last <= 100000000)
);

-- The month of `started` is the partition, so that a month is dropped at once. (run, started) identifies one run, so
-- that (run, slot) identifies one row although the partitions follow time. There is no foreign key to run: with one, a
-- new month would wait for every open transaction that has added a run. add_rows() is the only function that inserts,
-- and it locks the run.
CREATE TABLE gyrotherm.sample (
  started timestamptz NOT NULL,
  run uuid NOT NULL,
  slot integer NOT NULL,
  utc_ns bigint,
  numbers double precision[] NOT NULL,
  PRIMARY KEY (started, run, slot)
) PARTITION BY RANGE (started);

-- Months that rigs have opened. The table is also the lock under which a month is made: no rig can lock it by itself.
CREATE TABLE gyrotherm.month_made (
  partition text PRIMARY KEY,
  owner name NOT NULL,
  made timestamptz NOT NULL -- by the server's clock: a bound, not a key
);

-- The summary of dropped samples: the count, mean, lowest and highest number of each channel in each hour.
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

-- A model, a report or a certificate, byte for byte: sha256 is that of the text in UTF-8.
CREATE TABLE gyrotherm.document (
  sha256 text PRIMARY KEY,
  kind text NOT NULL, -- calibration, model, report
  schema text NOT NULL,
  name text NOT NULL, -- of the file
  rig text NOT NULL REFERENCES gyrotherm.rig,
  owner name NOT NULL,
  text text NOT NULL
);

-- A document has a sender for each role that sent these bytes; document.owner is the first of them.
CREATE TABLE gyrotherm.document_sender (
  sha256 text NOT NULL REFERENCES gyrotherm.document,
  owner name NOT NULL,
  rig text NOT NULL REFERENCES gyrotherm.rig,
  name text NOT NULL,
  PRIMARY KEY (sha256, owner)
);

-- The content of a calibration report. The store itself reads it from the document.
CREATE TABLE gyrotherm.calibration (
  sha256 text PRIMARY KEY REFERENCES gyrotherm.document,
  serial_number text NOT NULL,
  model text NOT NULL,
  number text NOT NULL,
  state text NOT NULL, -- draft, authorised, superseded
  simulated boolean NOT NULL,
  calibrated date NOT NULL, -- the day on which its last record ended
  issued date,
  CONSTRAINT calibration_has_a_unit CHECK (serial_number <> ''),
  CONSTRAINT calibration_is_of_a_day CHECK (isfinite(calibrated) AND isfinite(issued))
);
CREATE INDEX ON gyrotherm.calibration (serial_number, calibrated);

-- The bounds keep squares, differences and ratios of results finite.
CREATE TABLE gyrotherm.calibration_result (
  sha256 text NOT NULL REFERENCES gyrotherm.calibration,
  number integer NOT NULL,
  axis text NOT NULL,
  stage text NOT NULL, -- uncompensated, as_found, as_left
  quantity text NOT NULL, -- KEY.QUANTITY, as in docs/calibration-report.md
  condition text NOT NULL, -- profile, detail, the other columns of its row, and the zero of the bias
  value double precision,
  standard_uncertainty double precision,
  expanded_uncertainty double precision,
  unit text NOT NULL,
  in_sample boolean NOT NULL,
  PRIMARY KEY (sha256, number),
  CONSTRAINT result_is_a_number
    CHECK ((value = 0 OR abs(value) BETWEEN 1e-150 AND 1e100)
           AND (standard_uncertainty = 0 OR abs(standard_uncertainty) BETWEEN 1e-150 AND 1e100)
           AND (expanded_uncertainty = 0 OR abs(expanded_uncertainty) BETWEEN 1e-150 AND 1e100))
);
CREATE INDEX ON gyrotherm.calibration_result (quantity, stage);

-- Each result of a unit against the one before. make_drift() computes the rows of a unit whenever a calibration of it
-- comes, in whatever order they come, so that a question costs nothing.
CREATE TABLE gyrotherm.drift (
  sha256 text NOT NULL,
  number integer NOT NULL,
  serial_number text NOT NULL,
  model text NOT NULL,
  axis text NOT NULL,
  stage text NOT NULL,
  quantity text NOT NULL,
  condition text NOT NULL,
  unit text NOT NULL,
  calibrated date NOT NULL,
  value double precision,
  expanded_uncertainty double precision,
  calibrated_before date,
  value_before double precision,
  change double precision,
  e_n double precision,
  is_newest boolean NOT NULL,
  lot bigint NOT NULL, -- equal if model, axis, stage, quantity, condition, unit and simulated are
  PRIMARY KEY (sha256, number),
  FOREIGN KEY (sha256, number) REFERENCES gyrotherm.calibration_result (sha256, number)
);
CREATE INDEX ON gyrotherm.drift (serial_number);
CREATE INDEX ON gyrotherm.drift (abs(e_n) DESC NULLS LAST);
CREATE INDEX ON gyrotherm.drift (lot) INCLUDE (value) WHERE is_newest AND value IS NOT NULL;

-- One row for each unit with calibrations. Two reports of one unit take turns at its drift by locking this row, which
-- no rig can lock by itself.
CREATE TABLE gyrotherm.drift_turn (
  serial_number text NOT NULL,
  model text NOT NULL,
  PRIMARY KEY (serial_number, model)
);

-- Units are known from the runs and calibrations that name them.
CREATE VIEW gyrotherm.unit AS
  SELECT serial_number, model FROM gyrotherm.run_unit UNION SELECT serial_number, model FROM gyrotherm.calibration;

-- Converts nanoseconds since 1970 to the server's time, to the microsecond.
CREATE FUNCTION gyrotherm.utc(ns bigint) RETURNS timestamptz LANGUAGE sql IMMUTABLE PARALLEL SAFE
RETURN 'epoch'::timestamptz + ns / 1000 * interval '1 microsecond';

-- Functions of the owner alone

-- Makes the partition of a month if it does not exist. It is made beside the table and attached, so that writers of
-- other months wait for a moment only. A role may open 24 months a day: each month slows every question about all
-- samples.
CREATE FUNCTION gyrotherm.make_month(a_month timestamptz) RETURNS void
LANGUAGE plpgsql SET search_path = pg_catalog, pg_temp SET timezone = 'UTC' AS $$
DECLARE
  first timestamptz := date_trunc('month', a_month);
  following timestamptz := first + interval '1 month';
  partition text := 'sample_' || to_char(first, 'YYYY_MM');
BEGIN
  IF to_regclass('gyrotherm.' || partition) IS NOT NULL THEN RETURN; END IF;
  LOCK TABLE gyrotherm.month_made IN SHARE ROW EXCLUSIVE MODE;
  -- A session that waited for the lock finds the month of another one in the catalogue, not yet by its name.
  IF EXISTS (SELECT FROM pg_class WHERE relnamespace = 'gyrotherm'::regnamespace AND relname = partition) THEN
    RETURN;
  END IF;
  IF (SELECT count(*) FROM gyrotherm.month_made m
      WHERE m.owner = session_user AND m.made > now() - interval '1 day') >= 24 THEN
    PERFORM gyrotherm.refuse(format('%s has opened 24 months of samples within a day', session_user));
  END IF;
  EXECUTE format('CREATE TABLE gyrotherm.%I (LIKE gyrotherm.sample INCLUDING DEFAULTS, '
                 'CHECK (started >= %L AND started < %L))', partition, first, following);
  EXECUTE format('ALTER TABLE gyrotherm.sample ATTACH PARTITION gyrotherm.%I FOR VALUES FROM (%L) TO (%L)',
                 partition, first, following);
  INSERT INTO gyrotherm.month_made(partition, owner, made) VALUES (partition, session_user, now())
  ON CONFLICT ON CONSTRAINT month_made_pkey DO UPDATE SET owner = EXCLUDED.owner, made = EXCLUDED.made;
END
$$;

-- Drops the samples of the runs that started in a month, and returns the number of these runs. All of them must be
-- finished. The runs, the summary of each hour, events and calibrations remain. With `detach` the partition remains as
-- a table of its own, gyrotherm.dropped_YYYY_MM, for pg_dump. A number that no mean can be made of is left out of the
-- summary.
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
    WHERE s.started >= first AND s.started < following AND abs(n.value) < 1e100
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

-- Ends a run that no rig will finish: it takes no more rows.
CREATE FUNCTION gyrotherm.give_up(a_run uuid) RETURNS void
LANGUAGE sql SET search_path = pg_catalog, pg_temp AS $$
  UPDATE gyrotherm.run SET finished = true, state = 'given up', rows_in_record = rows
  WHERE id = a_run AND NOT finished;
$$;

-- Functions that the functions for rigs call

-- Fails with a reason. The type lets it be called where a row of numbers is expected.
CREATE FUNCTION gyrotherm.refuse(why text) RETURNS double precision[]
LANGUAGE plpgsql SET search_path = pg_catalog, pg_temp AS $$
BEGIN
  RAISE EXCEPTION '%', why USING ERRCODE = '22023';
END
$$;

-- Returns the caller's run, locked until the transaction ends. Fails in the same way if there is no such run and if it
-- belongs to another role.
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

-- Refuses alarms that are not a list, or that each look at v1_live would have to read for long. A publisher sends at
-- most 256 rows of some hundred bytes.
CREATE FUNCTION gyrotherm.check_alarms(a_alarms jsonb) RETURNS void
LANGUAGE plpgsql SET search_path = pg_catalog, pg_temp AS $$
BEGIN
  IF jsonb_typeof(a_alarms) IS DISTINCT FROM 'array' OR octet_length(a_alarms::text) > 1000000 THEN
    PERFORM gyrotherm.refuse('the alarms are not a list of rows');
  END IF;
END
$$;

-- Checks that the rig of that name belongs to the caller. A new name belongs to the caller from now on. A name that
-- exists is read, not inserted: a role waits only for one that claims the same new name.
CREATE FUNCTION gyrotherm.own_rig(a_rig text) RETURNS void
LANGUAGE plpgsql SET search_path = pg_catalog, pg_temp AS $$
BEGIN
  IF NOT EXISTS (SELECT FROM gyrotherm.rig WHERE name = a_rig) THEN
    INSERT INTO gyrotherm.rig(name, owner) VALUES (a_rig, session_user) ON CONFLICT DO NOTHING;
  END IF;
  PERFORM FROM gyrotherm.rig WHERE name = a_rig AND owner = session_user;
  IF NOT FOUND THEN
    RAISE EXCEPTION 'rig "%" is not one of %', a_rig, session_user USING ERRCODE = '42501';
  END IF;
END
$$;

-- Ends the sessions of rigs whose transaction is older than a minute, which no publisher waits for (longest_answer).
-- Returns their number. Returns -1 if the owner of the store is not a member of pg_signal_backend.
CREATE FUNCTION gyrotherm.end_stale() RETURNS integer
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp AS $$
BEGIN
  RETURN (SELECT count(*) FILTER (WHERE pg_terminate_backend(a.pid)) FROM pg_stat_activity a
          WHERE a.datname = current_database() AND a.pid <> pg_backend_pid()
            AND a.xact_start < clock_timestamp() - interval '1 minute'
            AND pg_has_role(a.usesysid, 'gyrotherm_rig', 'MEMBER')
            AND NOT EXISTS (SELECT FROM pg_roles r WHERE r.oid = a.usesysid AND r.rolsuper));
EXCEPTION WHEN insufficient_privilege THEN
  RETURN -1;
END
$$;

-- Calibrations and their drift

-- Reports that count: at least one sender of the report has neither replaced nor superseded it. A role replaces its own
-- reports only, and a report replaces one of its own kind, real or simulated. If several reports of one unit and day
-- have one number, the authorised one counts. A draft counts if no report of that day is authorised.
CREATE VIEW gyrotherm.current_calibration AS
  SELECT c.* FROM gyrotherm.calibration c
  WHERE c.state <> 'superseded' AND EXISTS (
    SELECT FROM gyrotherm.document_sender d
    WHERE d.sha256 = c.sha256 AND NOT EXISTS (
      SELECT FROM gyrotherm.calibration o JOIN gyrotherm.document_sender p USING (sha256)
      WHERE o.serial_number = c.serial_number AND o.model = c.model AND o.simulated = c.simulated
        AND (p.owner = d.owner OR c.state = 'draft')
        AND (o.state = 'superseded' AND o.number = c.number AND c.number <> ''
             OR o.state <> 'superseded' AND o.calibrated = c.calibrated AND (o.number = c.number OR c.state = 'draft')
                AND (o.state, o.sha256) < (c.state, c.sha256))));

-- Computes the drift of a unit anew, real and simulated calibrations apart. As found is compared with the as left
-- before it, so that the change is the drift of the compensated unit. As left against as found of the same day is an
-- adjustment and no change. E_n = change / sqrt(U^2 + U_before^2) (ISO 13528:2022, 9.7): beyond 1 the two do not agree.
CREATE FUNCTION gyrotherm.make_drift(a_serial_number text, a_model text) RETURNS void
LANGUAGE plpgsql SET search_path = pg_catalog, pg_temp AS $$
BEGIN
  INSERT INTO gyrotherm.drift_turn VALUES (a_serial_number, a_model) ON CONFLICT DO NOTHING;
  PERFORM FROM gyrotherm.drift_turn WHERE serial_number = a_serial_number AND model = a_model FOR UPDATE;
  DELETE FROM gyrotherm.drift WHERE serial_number = a_serial_number AND model = a_model;
  INSERT INTO gyrotherm.drift
  SELECT sha256, result, serial_number, model, axis, stage, quantity, condition, unit, calibrated, value,
         expanded_uncertainty, calibrated_before, value_before, change,
         change / nullif(sqrt(expanded_uncertainty ^ 2 + uncertainty_before ^ 2), 0), calibrated = newest,
         hashtextextended(concat_ws('|', model, axis, stage, quantity, condition, unit,
                                    CASE WHEN simulated THEN 'simulated' END), 0)
  FROM (
    SELECT *, CASE WHEN stage <> 'as_left' OR stage_before <> 'as_found' THEN value - value_before END AS change
    FROM (
      SELECT c.*, r.number AS result, r.axis, r.stage, r.quantity, r.condition, r.unit, r.value, r.expanded_uncertainty,
             lag(r.value) OVER series AS value_before, lag(r.expanded_uncertainty) OVER series AS uncertainty_before,
             lag(r.stage) OVER series AS stage_before, lag(c.calibrated) OVER series AS calibrated_before,
             max(c.calibrated) OVER (PARTITION BY c.simulated) AS newest
      FROM gyrotherm.current_calibration c JOIN gyrotherm.calibration_result r USING (sha256)
      WHERE c.serial_number = a_serial_number AND c.model = a_model AND r.expanded_uncertainty IS NOT NULL
        AND NOT r.in_sample
      WINDOW series AS (PARTITION BY c.simulated, r.axis, r.stage = 'uncompensated', r.quantity, r.condition, r.unit
                        ORDER BY c.calibrated, r.stage, c.sha256)
    ) pairs
  ) changes;
END
$$;

-- Appends the zero of the bias to the conditions of the results that depend on it, so that drift and outliers compare
-- results of one zero. The mean of a record's first hold is a zero of that run alone, so the run is appended too. A
-- report without a zero is left as it is. The quantities and the keyword are those of report/comparison.hpp and
-- analysis/data/dataset.hpp; tests/report/comparison_test.cpp compares them.
CREATE FUNCTION gyrotherm.name_zeros(a_sha256 text) RETURNS void
LANGUAGE sql SET search_path = pg_catalog, pg_temp AS $$
  WITH report AS (
    SELECT text::jsonb AS d FROM gyrotherm.document WHERE sha256 = a_sha256
  ), own AS (
    SELECT z->>'axis' AS axis, z->>'run' AS run, z->>'zero' AS zero
    FROM report, jsonb_array_elements(d->'bias_zeros') AS z
  ), counted AS (
    SELECT row_number() OVER (ORDER BY r.n, c.n, v.n) AS number, r.value->>'axis' AS axis, r.value->>'run' AS run,
           c.value->>'quantity' IN ('bias', 'mean', 'rmse', 'largest', 'compensated_bias') AS depends_on_it,
           d->>'bias_zero' AS zero
    FROM report, jsonb_array_elements(d->'results') WITH ORDINALITY AS r(value, n),
      jsonb_array_elements(r.value->'columns') WITH ORDINALITY AS c(value, n),
      jsonb_array_elements(c.value->'values') WITH ORDINALITY AS v(value, n)
  ), named AS (
    SELECT number, counted.run, coalesce(own.zero, nullif(counted.zero, '')) AS zero
    FROM counted LEFT JOIN own USING (axis, run) WHERE depends_on_it
  )
  UPDATE gyrotherm.calibration_result r
  SET condition = concat_ws(', ', nullif(r.condition, ''), n.zero,
                            CASE WHEN n.zero = 'mean of the first hold removed' THEN 'run ' || n.run END)
  FROM named n WHERE r.sha256 = a_sha256 AND r.number = n.number AND n.zero IS NOT NULL;
$$;

-- Names the zeros of new results and computes the drift of their units.
CREATE FUNCTION gyrotherm.results_came() RETURNS trigger
LANGUAGE plpgsql SET search_path = pg_catalog, pg_temp AS $$
BEGIN
  PERFORM gyrotherm.name_zeros(sha256) FROM (SELECT DISTINCT sha256 FROM came) c;
  PERFORM gyrotherm.make_drift(u.serial_number, u.model)
  FROM (SELECT DISTINCT c.serial_number, c.model FROM came JOIN gyrotherm.calibration c USING (sha256)
        ORDER BY c.serial_number, c.model) u;
  RETURN NULL;
END
$$;
CREATE TRIGGER results_came AFTER INSERT ON gyrotherm.calibration_result REFERENCING NEW TABLE AS came
  FOR EACH STATEMENT EXECUTE FUNCTION gyrotherm.results_came();

-- Functions for rigs. A call waits 10 s for a lock of another rig, then fails; the publisher tries again.

-- Returns the number of the last migration.
CREATE FUNCTION gyrotherm.version() RETURNS integer
LANGUAGE sql STABLE SECURITY DEFINER SET search_path = pg_catalog, pg_temp AS $$
  SELECT max(number) FROM gyrotherm.migration;
$$;

-- Returns the position of a run of the caller; no row if there is none.
CREATE FUNCTION gyrotherm.run_position(a_run uuid)
RETURNS TABLE (last_slot integer, last_event bigint, last_gap integer, finished boolean, dropped boolean)
LANGUAGE sql STABLE SECURITY DEFINER SET search_path = pg_catalog, pg_temp AS $$
  SELECT r.last_slot, r.last_event, r.last_gap, r.finished, r.dropped
  FROM gyrotherm.run r WHERE r.id = a_run AND r.owner = session_user;
$$;

-- Adds a run with its channels: {"started_ns", "profile", "simulated", "imported", "channels": [{"name", "unit",
-- "measures", "unit_under_test", "words", "calibration"}], "units": [{"label", "serial_number", "model"}], …}. All but
-- the channels is kept as run.info. The same run again changes nothing; a different one is refused. A run on a virtual
-- rig does not change the thermometers of the rig.
CREATE FUNCTION gyrotherm.add_run(a_run uuid, a_rig text, a_info jsonb) RETURNS void
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp SET timezone = 'UTC' SET lock_timeout = '10s'
AS $$
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
    PERFORM gyrotherm.end_stale();
    PERFORM gyrotherm.own_rig(a_rig);
    PERFORM gyrotherm.make_month(begun);
    INSERT INTO gyrotherm.run(id, rig, owner, started, profile, simulated, imported, info, heard)
    VALUES (a_run, a_rig, session_user, begun, a_info->>'profile', (a_info->>'simulated')::boolean,
            (a_info->>'imported')::boolean, kept, now())
    ON CONFLICT DO NOTHING;
    is_new := FOUND;
  END IF;
  IF NOT is_new THEN -- or another session was faster
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
  INSERT INTO gyrotherm.run_unit(run, label, serial_number, model)
  SELECT a_run, u->>'label', u->>'serial_number', u->>'model' FROM jsonb_array_elements(a_info->'units') u
  WHERE u->>'serial_number' <> '';
  IF (a_info->>'simulated')::boolean THEN RETURN; END IF;
  INSERT INTO gyrotherm.thermometer(rig, name, instrument, certificate, calibrated, due, run, started)
  SELECT a_rig, c->>'name', c->'calibration'->>'instrument', c->'calibration'->>'certificate',
         nullif(c->'calibration'->>'calibrated', '')::date, nullif(c->'calibration'->>'due', '')::date, a_run, begun
  FROM jsonb_array_elements(a_info->'channels') c WHERE c->>'measures' = 'temperature' AND c ? 'calibration'
  ON CONFLICT (rig, name) DO UPDATE SET instrument = EXCLUDED.instrument, certificate = EXCLUDED.certificate,
    calibrated = EXCLUDED.calibrated, due = EXCLUDED.due, run = EXCLUDED.run, started = EXCLUDED.started
  WHERE gyrotherm.thermometer.started < EXCLUDED.started;
END
$$;

-- Adds rows behind slot `after`, the first and the last slot at their ends. Slot `after` must not lie behind the last
-- stored slot, so that rows have no holes. Each of `numbers` is an array as text, "{1.5,NULL}", with a number for each
-- channel. Rows that exist must be equal; then nothing changes. Returns the last slot of the run.
CREATE FUNCTION gyrotherm.add_rows(a_run uuid, a_after integer, slots integer[], utcs bigint[], numbers text[])
RETURNS integer
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp SET lock_timeout = '10s' AS $$
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
    UPDATE gyrotherm.run SET rows = rows + added, heard = now(), last_slot = greatest(last_slot, last_one),
      last_utc_ns = CASE WHEN last_one > last_slot THEN utcs[cardinality(utcs)] ELSE last_utc_ns END
    WHERE id = a_run;
  END IF;
  RETURN greatest(to_run.last_slot, last_one);
END
$$;

-- Adds events behind number `after`, in order of their numbers: [{"number", "slot", "utc_ns", "kind", "interlock",
-- "reaction", "segment", "channel", "text"}]. Otherwise like add_rows().
CREATE FUNCTION gyrotherm.add_events(a_run uuid, a_after bigint, a_events jsonb) RETURNS bigint
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp SET lock_timeout = '10s' AS $$
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

-- Adds gaps behind the gap that begins at slot `after`, in order: [{"first", "last", "cause"}]. Otherwise like
-- add_rows().
CREATE FUNCTION gyrotherm.add_gaps(a_run uuid, a_after integer, a_gaps jsonb) RETURNS integer
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp SET lock_timeout = '10s' AS $$
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

-- Sets the state of an unfinished run, its cause and its alarms.
CREATE FUNCTION gyrotherm.say_state(a_run uuid, a_state text, a_cause text, a_alarms jsonb) RETURNS void
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp SET lock_timeout = '10s' AS $$
DECLARE
  to_run gyrotherm.run := gyrotherm.own_run(a_run);
BEGIN
  PERFORM gyrotherm.check_alarms(a_alarms);
  UPDATE gyrotherm.run SET state = a_state, cause = a_cause, alarms = a_alarms
  WHERE id = a_run AND NOT finished AND (state, cause, alarms) IS DISTINCT FROM (a_state, a_cause, a_alarms);
END
$$;

-- Ends a run: {"state", "cause", "alarms", "ended_ns", "rows", "events", "gaps", "chain_head", "files"}. Refuses if the
-- store has fewer rows, events or gaps than the record. The same end again changes nothing.
CREATE FUNCTION gyrotherm.finish_run(a_run uuid, a_end jsonb) RETURNS void
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp SET lock_timeout = '10s' AS $$
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
  PERFORM gyrotherm.check_alarms(a_end->'alarms');
  UPDATE gyrotherm.run SET finished = true, state = a_end->>'state', cause = a_end->>'cause',
    alarms = a_end->'alarms', ended = gyrotherm.utc((a_end->>'ended_ns')::bigint),
    chain_head = a_end->>'chain_head', files = a_end->'files', rows_in_record = (a_end->>'rows')::bigint
  WHERE id = a_run;
END
$$;

-- Returns whether the caller has sent this document.
CREATE FUNCTION gyrotherm.has_document(a_sha256 text) RETURNS boolean
LANGUAGE sql STABLE SECURITY DEFINER SET search_path = pg_catalog, pg_temp AS $$
  SELECT EXISTS (SELECT FROM gyrotherm.document_sender WHERE sha256 = a_sha256 AND owner = session_user);
$$;

-- Adds a model, a report or a calibration, and returns its SHA-256. The content of a calibration is read from its bytes
-- here, so that no rig can report it differently.
CREATE FUNCTION gyrotherm.add_document(a_rig text, a_kind text, a_name text, a_text text) RETURNS text
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp SET lock_timeout = '10s' AS $$
DECLARE
  digest text := encode(sha256(convert_to(a_text, 'UTF8')), 'hex');
  d jsonb := a_text::jsonb;
  is_new boolean;
BEGIN
  PERFORM gyrotherm.end_stale();
  PERFORM gyrotherm.own_rig(a_rig);
  IF a_kind NOT IN ('calibration', 'model', 'report') OR d->>'schema' NOT LIKE 'gyrotherm-' || a_kind || '/%' THEN
    PERFORM gyrotherm.refuse('it is no such document');
  END IF;
  INSERT INTO gyrotherm.document(sha256, kind, schema, name, rig, owner, text)
  VALUES (digest, a_kind, d->>'schema', a_name, a_rig, session_user, a_text) ON CONFLICT DO NOTHING;
  is_new := FOUND;
  INSERT INTO gyrotherm.document_sender(sha256, owner, rig, name)
  VALUES (digest, session_user, a_rig, a_name) ON CONFLICT DO NOTHING;
  IF NOT FOUND OR a_kind <> 'calibration' OR d->'item'->>'serial_number' = ''
     OR coalesce(d->>'ended', '') = '' THEN
    RETURN digest;
  END IF;
  IF NOT is_new THEN -- another sender of the same report may make it count again
    PERFORM gyrotherm.make_drift(d->'item'->>'serial_number', d->'item'->>'model');
    RETURN digest;
  END IF;
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
          -- The first column of a table, if it has no uncertainty, is the condition of the others, such as a set point.
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

-- Views for people. Columns of a view whose name begins with v1 remain; further ones may follow them.

CREATE VIEW gyrotherm.v1_run AS
  SELECT id AS run, rig, started, profile, simulated, state, cause, finished, ended, rows, gaps,
         gyrotherm.utc(last_utc_ns) AS last_row, chain_head,
         files->0->>'sha256' AS sha256, (files->0->>'bytes')::bigint AS bytes, dropped
  FROM gyrotherm.run;

CREATE VIEW gyrotherm.v1_channel AS
  SELECT run, position, name, unit, measures, unit_under_test, calibration->>'certificate' AS certificate,
         nullif(calibration->>'due', '')::date AS due
  FROM gyrotherm.channel;

-- Samples as recorded: readings are raw, and channel.calibration converts them to temperatures. A number without a
-- keyword has none.
CREATE VIEW gyrotherm.v1_sample AS
  SELECT s.run, s.slot, gyrotherm.utc(s.utc_ns) AS utc, c.name, n.value, c.unit,
         c.words[CASE WHEN n.value >= 0 AND n.value < cardinality(c.words) THEN n.value::integer + 1 END] AS word
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

CREATE VIEW gyrotherm.v1_drift AS
  SELECT d.serial_number, d.model, d.axis, d.stage, d.quantity, d.condition, d.calibrated, d.value,
         d.expanded_uncertainty, d.unit, d.calibrated_before, d.value_before, d.change, d.e_n,
         d.change / nullif((d.calibrated - d.calibrated_before) / 365.25, 0) AS change_per_year, c.state, c.number,
         c.simulated
  FROM gyrotherm.drift d JOIN gyrotherm.calibration c USING (sha256);

-- Outliers: the newest result of each unit among all units of its model. z = 0.6745 (x - median) / MAD; beyond 3.5 it
-- is one (Iglewicz & Hoaglin 1993). A lot of fewer than five units has no outliers.
CREATE VIEW gyrotherm.v1_outlier AS
  WITH middle AS (
    SELECT lot, array_agg(value) AS numbers, percentile_cont(0.5) WITHIN GROUP (ORDER BY value) AS median
    FROM gyrotherm.drift WHERE is_newest AND value IS NOT NULL GROUP BY lot HAVING count(*) >= 5
  ), spread AS MATERIALIZED (
    SELECT lot, cardinality(numbers) AS units, median,
           (SELECT percentile_cont(0.5) WITHIN GROUP (ORDER BY abs(n - median)) FROM unnest(numbers) n) AS mad
    FROM middle
  )
  SELECT d.serial_number, d.model, d.axis, d.stage, d.quantity, d.condition, d.calibrated, d.value, d.unit, s.median,
         s.mad, 0.6745 * (d.value - s.median) / s.mad AS robust_z, s.units, c.simulated
  FROM spread s JOIN gyrotherm.drift d USING (lot) JOIN gyrotherm.calibration c USING (sha256)
  WHERE d.is_newest AND d.value IS NOT NULL AND s.mad > 0 AND abs(0.6745 * (d.value - s.median) / s.mad) > 3.5;

-- Thermometers and the day on which their calibration ends.
CREATE VIEW gyrotherm.v1_thermometer AS
  SELECT rig, name, instrument, certificate, calibrated, due, due - current_date AS days_left, started AS last_used
  FROM gyrotherm.thermometer;

-- Hours that a rig ran, by ISO week (its Monday, UTC). A run in progress counts to its last row. Imported runs are left
-- out: their rig is unknown.
CREATE VIEW gyrotherm.v1_utilisation AS
  SELECT r.rig, w.week::date AS week, count(*) AS runs, sum(t.seconds) / 3600 AS hours,
         sum(t.seconds) / 6048 AS percent, r.simulated
  FROM (SELECT rig, simulated, started AT TIME ZONE 'UTC' AS started,
               coalesce(gyrotherm.utc(last_utc_ns), started) AT TIME ZONE 'UTC' AS until
        FROM gyrotherm.run WHERE NOT imported) r
  CROSS JOIN LATERAL generate_series(date_trunc('week', r.started), r.until, interval '7 days') AS w(week)
  CROSS JOIN LATERAL (SELECT extract(epoch FROM least(r.until, w.week + interval '7 days')
                                            - greatest(r.started, w.week)) AS seconds) t
  GROUP BY r.rig, w.week, r.simulated;

-- Runs that a person should look at, and the reason. An alarm is the action of an interlock or a warning, whose event
-- has the kind `fault`. One row per alarm tag, which is an interlock and its channel. An acknowledgement has the number
-- of the alarm in its range: "alarm 12 to 40 acknowledged by …" (docs/interlocks.md). A run is silent if it is neither
-- finished nor aborted and its last row is ten minutes old.
CREATE VIEW gyrotherm.v1_attention AS
  SELECT r.id AS run, r.rig, r.started, r.profile, a.what, a.detail, r.simulated
  FROM gyrotherm.run r
  CROSS JOIN LATERAL (
    SELECT 'aborted' AS what, r.cause AS detail WHERE r.state IN ('aborting', 'aborted')
    UNION ALL
    SELECT 'alarm', (array_agg(e.text ORDER BY e.number DESC))[1] ||
                    CASE WHEN count(*) > 1 THEN format(' (%s times)', count(*)) ELSE '' END
    FROM gyrotherm.event e
    WHERE e.run = r.id AND e.kind IN ('interlock', 'fault') AND e.interlock <> '' AND NOT EXISTS (
      SELECT FROM gyrotherm.event k
      CROSS JOIN LATERAL regexp_match(k.text, '^alarm ([0-9]{1,18})(?: to ([0-9]{1,18}))? acknowledged') AS m
      WHERE k.run = r.id AND k.kind = 'acknowledged' AND m IS NOT NULL
        AND e.number BETWEEN m[1]::bigint AND coalesce(m[2], m[1])::bigint
        AND (m[2] IS NULL OR (k.interlock, coalesce(k.channel, '')) = (e.interlock, coalesce(e.channel, ''))))
    GROUP BY e.interlock, e.channel
    UNION ALL
    SELECT 'gaps', format('%s gaps, %s s without rows', count(*), sum(g.last - g.first + 1))
    FROM gyrotherm.gap g WHERE g.run = r.id HAVING count(*) > 0
    UNION ALL
    SELECT 'silent', format('%s; last row %s', r.state,
                            coalesce(to_char(gyrotherm.utc(r.last_utc_ns) AT TIME ZONE 'UTC',
                                             'YYYY-MM-DD"T"HH24:MI:SS"Z"'), 'none'))
    WHERE NOT r.finished AND r.state <> 'aborted'
      AND coalesce(gyrotherm.utc(r.last_utc_ns), r.started) < now() - interval '10 minutes'
    UNION ALL
    SELECT 'more rows than its record', format('%s rows here, %s in the record', r.rows, r.rows_in_record)
    WHERE r.rows > r.rows_in_record
  ) a;

-- Each rig, and the run on it that began last: a run of its own before those that it imported, and both before virtual
-- ones.
CREATE VIEW gyrotherm.v1_rig AS
  SELECT g.name AS rig, g.owner, CASE WHEN r.finished THEN 'idle' ELSE r.state END AS state, r.profile, r.started,
         gyrotherm.utc(r.last_utc_ns) AS last_row,
         (SELECT string_agg(u.serial_number, ' ' ORDER BY u.label)
          FROM gyrotherm.run_unit u WHERE u.run = r.id) AS units,
         (SELECT count(*) FROM gyrotherm.run o WHERE o.rig = g.name) AS runs, r.id AS run, r.simulated
  FROM gyrotherm.rig g
  LEFT JOIN LATERAL (
    SELECT * FROM gyrotherm.run o WHERE o.rig = g.name
    ORDER BY o.simulated, o.imported, o.started DESC LIMIT 1) r ON true;

-- Runs with the age of their last second: since the row came, or since it was measured by the clock of the rig,
-- whichever is greater. The clock of a virtual rig does not count.
CREATE VIEW gyrotherm.run_now AS
  SELECT *, greatest(now() - heard, CASE WHEN NOT simulated THEN now() - coalesce(gyrotherm.utc(last_utc_ns), started)
                     END, interval '0') AS age
  FROM gyrotherm.run;

-- Each rig as it is now: the run in progress, a real one before one on a virtual rig, or the last run. A run that has
-- not ended is silent if its last second is older than one minute. A run that was aborted, or ended with unacknowledged
-- alarms, remains until the next one. A suppressed alarm is acknowledged with its root.
CREATE VIEW gyrotherm.v1_live AS
  SELECT g.name AS rig, n.state, r.cause, r.profile,
         CASE WHEN n.state NOT IN ('idle', 'silent') THEN r.info->'segments'->l.segment->>'name' END AS segment,
         CASE WHEN n.state NOT IN ('idle', 'silent') AND NOT r.finished THEN l.chamber_air_c END AS chamber_air_c,
         CASE WHEN n.state NOT IN ('idle', 'silent') AND NOT r.finished THEN l.set_point_c END AS set_point_c,
         a.unacknowledged AS alarms, round(extract(epoch FROM r.age)) AS age_s, r.simulated, r.started, r.id AS run
  FROM gyrotherm.rig g
  LEFT JOIN LATERAL (
    (SELECT o.*, 1 AS choice FROM gyrotherm.run_now o
     WHERE o.rig = g.name AND NOT o.finished AND o.state <> 'aborted' AND o.age <= interval '1 minute'
     ORDER BY o.simulated, o.imported, o.started DESC LIMIT 1)
    UNION ALL
    (SELECT o.*, 2 FROM gyrotherm.run_now o WHERE o.rig = g.name
     ORDER BY o.simulated, o.imported, o.started DESC LIMIT 1)
    ORDER BY choice LIMIT 1) r ON true
  LEFT JOIN LATERAL (
    SELECT count(*) AS unacknowledged FROM jsonb_array_elements(r.alarms) e
    WHERE e->>'acknowledged' IS DISTINCT FROM 'true' AND coalesce(e->>'suppressed_by', '') = '') a ON r.id IS NOT NULL
  CROSS JOIN LATERAL (
    SELECT CASE WHEN r.state = 'aborted' OR r.finished AND a.unacknowledged > 0 THEN r.state
                WHEN r.finished OR r.id IS NULL THEN 'idle'
                WHEN r.age > interval '1 minute' THEN 'silent'
                ELSE r.state END AS state) n
  LEFT JOIN LATERAL (
    SELECT max(n.value) FILTER (WHERE c.name = 'chamber_air_c') AS chamber_air_c,
           max(n.value) FILTER (WHERE c.name = 'set_point_c') AS set_point_c,
           (max(n.value) FILTER (WHERE c.name = 'segment' AND n.value >= 0))::integer AS segment
    FROM gyrotherm.sample s JOIN gyrotherm.channel c ON c.run = s.run
    CROSS JOIN LATERAL (SELECT s.numbers[c.position] AS value) n
    WHERE s.started = r.started AND s.run = r.id AND s.slot = r.last_slot
      AND c.name IN ('chamber_air_c', 'set_point_c', 'segment') AND abs(n.value) < 1e6) l ON true;

-- Rights

REVOKE ALL ON ALL FUNCTIONS IN SCHEMA gyrotherm FROM PUBLIC;
GRANT EXECUTE ON FUNCTION gyrotherm.version(), gyrotherm.utc(bigint) TO gyrotherm_rig, gyrotherm_analyst;
GRANT EXECUTE ON FUNCTION gyrotherm.run_position(uuid), gyrotherm.add_run(uuid, text, jsonb),
  gyrotherm.add_rows(uuid, integer, integer[], bigint[], text[]), gyrotherm.add_events(uuid, bigint, jsonb),
  gyrotherm.add_gaps(uuid, integer, jsonb), gyrotherm.say_state(uuid, text, text, jsonb),
  gyrotherm.finish_run(uuid, jsonb), gyrotherm.has_document(text), gyrotherm.add_document(text, text, text, text)
  TO gyrotherm_rig;
GRANT SELECT ON ALL TABLES IN SCHEMA gyrotherm TO gyrotherm_analyst;
