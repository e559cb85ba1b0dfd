-- SPDX-License-Identifier: Apache-2.0
-- One rig cannot hold up the others. Before, a rig that left a transaction open kept its locks for as long as it liked:
-- a unit, the name of a rig, a month, the changes of a unit. An advisory lock, which every role may take, stopped each
-- first run of a month. A document belonged to the role that sent its bytes first, which could then supersede it for
-- everybody.

-- Ends the sessions of rigs whose transaction is older than a minute, which no publisher waits for (longest_answer).
-- Returns their number. Returns -1 where the owner of the store is not a member of pg_signal_backend.
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

-- Units are known from the runs and calibrations that name them: no row is shared between the transactions of two rigs.
ALTER TABLE gyrotherm.run_unit DROP CONSTRAINT run_unit_serial_number_model_fkey;
ALTER TABLE gyrotherm.calibration DROP CONSTRAINT calibration_serial_number_model_fkey;
ALTER TABLE gyrotherm.calibration ADD CONSTRAINT calibration_has_a_unit CHECK (serial_number <> '') NOT VALID;
DROP TABLE gyrotherm.unit;
CREATE VIEW gyrotherm.unit AS
  SELECT serial_number, model FROM gyrotherm.run_unit UNION SELECT serial_number, model FROM gyrotherm.calibration;

-- add_rows(), the only way in, has the run locked. With the foreign key, a new month waited for each open transaction
-- that had added a run, and all others waited behind it.
ALTER TABLE gyrotherm.sample DROP CONSTRAINT sample_run_started_fkey;

-- Months that rigs have opened. The table is also the lock under which a month is made: no rig can lock it by itself.
CREATE TABLE gyrotherm.month_made (
  partition text PRIMARY KEY,
  owner name NOT NULL,
  made timestamptz NOT NULL -- by the server's clock: a bound, not a key
);

-- Makes the partition of a month if it does not exist. A role may open 24 months a day: each month slows every
-- question about all samples.
CREATE OR REPLACE FUNCTION gyrotherm.make_month(a_month timestamptz) RETURNS void
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

-- A rig's name that is there already is read, not inserted: a role waits only for one that claims the same new name.
CREATE OR REPLACE FUNCTION gyrotherm.own_rig(a_rig text) RETURNS void
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

-- As before, without the table of units.
CREATE OR REPLACE FUNCTION gyrotherm.add_run(a_run uuid, a_rig text, a_info jsonb) RETURNS void
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
    INSERT INTO gyrotherm.run(id, rig, owner, started, profile, simulated, imported, info)
    VALUES (a_run, a_rig, session_user, begun, a_info->>'profile', (a_info->>'simulated')::boolean,
            (a_info->>'imported')::boolean, kept)
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

-- A document has a sender for each role that sent these bytes; document.owner is the first of them.
CREATE TABLE gyrotherm.document_sender (
  sha256 text NOT NULL REFERENCES gyrotherm.document,
  owner name NOT NULL,
  rig text NOT NULL REFERENCES gyrotherm.rig,
  name text NOT NULL,
  PRIMARY KEY (sha256, owner)
);
INSERT INTO gyrotherm.document_sender(sha256, owner, rig, name) SELECT sha256, owner, rig, name FROM gyrotherm.document;

-- Returns whether the caller has sent this document.
CREATE OR REPLACE FUNCTION gyrotherm.has_document(a_sha256 text) RETURNS boolean
LANGUAGE sql STABLE SECURITY DEFINER SET search_path = pg_catalog, pg_temp AS $$
  SELECT EXISTS (SELECT FROM gyrotherm.document_sender WHERE sha256 = a_sha256 AND owner = session_user);
$$;

-- A report counts as long as one of its senders has neither replaced nor superseded it.
CREATE OR REPLACE VIEW gyrotherm.current_calibration AS
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

-- One row for each unit with calibrations: two reports of one unit take turns at its drift by locking this row.
CREATE TABLE gyrotherm.drift_turn (
  serial_number text NOT NULL,
  model text NOT NULL,
  PRIMARY KEY (serial_number, model)
);

-- As before, but that two reports of a unit take turns by a row that no rig can lock by itself.
CREATE OR REPLACE FUNCTION gyrotherm.make_drift(a_serial_number text, a_model text) RETURNS void
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

-- As before, but that a report may have several senders.
CREATE OR REPLACE FUNCTION gyrotherm.add_document(a_rig text, a_kind text, a_name text, a_text text) RETURNS text
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
          -- The first column of a table, if it has no uncertainty, is the condition of the others: a set point, a share.
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

-- A lock that another rig holds is waited for ten seconds; the publisher tries again.
ALTER FUNCTION gyrotherm.add_rows(uuid, integer, integer[], bigint[], text[]) SET lock_timeout = '10s';
ALTER FUNCTION gyrotherm.add_events(uuid, bigint, jsonb) SET lock_timeout = '10s';
ALTER FUNCTION gyrotherm.add_gaps(uuid, integer, jsonb) SET lock_timeout = '10s';
ALTER FUNCTION gyrotherm.say_state(uuid, text, text) SET lock_timeout = '10s';
ALTER FUNCTION gyrotherm.finish_run(uuid, jsonb) SET lock_timeout = '10s';

REVOKE ALL ON FUNCTION gyrotherm.end_stale() FROM PUBLIC;
GRANT SELECT ON gyrotherm.unit, gyrotherm.month_made, gyrotherm.document_sender, gyrotherm.drift_turn
  TO gyrotherm_analyst;
