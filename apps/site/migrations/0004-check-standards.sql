-- SPDX-License-Identifier: Apache-2.0
-- Check standards of rigs: the check runs of each history with their control charts (docs/check-standard.md).
--
-- The publisher sends the charts that it computed from the history, because only the charts know the history of the
-- values. A history is identified by the SHA-256 of its first line. Runs are only appended to it; an explanation changes
-- the verdicts of earlier runs, so each call replaces the charts of a history.

CREATE TABLE gyrotherm.check_standard (
  history text PRIMARY KEY CHECK (history ~ '^[0-9a-f]{64}$'),
  rig text NOT NULL REFERENCES gyrotherm.rig,
  owner name NOT NULL,
  rig_file text NOT NULL, -- the name of the rig in its rig file
  simulated boolean NOT NULL,
  serial_numbers text[] NOT NULL,
  profile text NOT NULL,
  false_alarm_rate double precision NOT NULL CHECK (false_alarm_rate > 0 AND false_alarm_rate < 1),
  -- The probable cause of a change that is not explained; NULL: no open run, or it cannot be told.
  cause text,
  cause_probability double precision CHECK (cause_probability BETWEEN 0 AND 1)
);

CREATE TABLE gyrotherm.check_run (
  history text NOT NULL REFERENCES gyrotherm.check_standard,
  number integer NOT NULL, -- from 1
  run text NOT NULL,
  started timestamptz NOT NULL CHECK (isfinite(started)),
  record text NOT NULL,
  sha256 text NOT NULL,
  verdict text NOT NULL CHECK (verdict IN ('not judged', 'in control', 'out of control', 'explained')),
  explained_cause text, -- of the explanation that covers it
  explained_by text,
  PRIMARY KEY (history, number)
);

CREATE TABLE gyrotherm.check_result (
  history text NOT NULL,
  number integer NOT NULL,
  chart integer NOT NULL, -- in the order of the results of the first run, from 1
  result text NOT NULL,
  unit text NOT NULL,
  value double precision,
  centre double precision,
  low double precision,
  high double precision,
  q double precision,
  ewma double precision,
  value_is_out boolean NOT NULL,
  ewma_is_out boolean NOT NULL,
  PRIMARY KEY (history, number, chart),
  FOREIGN KEY (history, number) REFERENCES gyrotherm.check_run (history, number),
  -- NULL passes; NaN and infinity do not.
  CONSTRAINT check_result_is_a_number
    CHECK (abs(value) < 1e100 AND abs(centre) < 1e100 AND abs(low) < 1e100 AND abs(high) < 1e100 AND abs(q) < 1e100
           AND abs(ewma) < 1e100)
);

-- Adds or replaces the charts of a history, as `gyrotherm standard --json` prints them. The runs that are there must be
-- the first runs of the charts, with the same records: a history only grows. A history belongs to the role that first
-- sent it.
CREATE FUNCTION gyrotherm.add_check_standard(a_rig text, a_history text, a_charts jsonb) RETURNS integer
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp SET timezone = 'UTC' SET lock_timeout = '10s'
SET jit = off -- the planner expects many rows in the arrays, and would compile the queries for seconds
AS $$
DECLARE
  there gyrotherm.check_standard;
  head jsonb := a_charts->'head';
BEGIN
  PERFORM gyrotherm.end_stale();
  PERFORM gyrotherm.own_rig(a_rig);
  IF a_charts->>'schema' IS DISTINCT FROM 'gyrotherm-control-charts/1' THEN
    PERFORM gyrotherm.refuse('it is no document with control charts');
  END IF;
  IF jsonb_array_length(a_charts->'runs') NOT BETWEEN 1 AND 5000 OR jsonb_array_length(a_charts->'charts') > 500 THEN
    PERFORM gyrotherm.refuse('a history has 1 to 5000 check runs and at most 500 charts');
  END IF;
  INSERT INTO gyrotherm.check_standard(history, rig, owner, rig_file, simulated, serial_numbers, profile,
                                       false_alarm_rate)
  VALUES (a_history, a_rig, session_user, head->>'rig', (head->>'simulated')::boolean,
          ARRAY(SELECT jsonb_array_elements_text(head->'serial_numbers')), head->>'profile',
          (head->>'false_alarm_rate')::double precision)
  ON CONFLICT DO NOTHING;
  SELECT * INTO there FROM gyrotherm.check_standard WHERE history = a_history FOR UPDATE;
  IF there.owner <> session_user OR there.rig <> a_rig THEN
    RAISE EXCEPTION 'history % is not one of % on %', a_history, session_user, a_rig USING ERRCODE = '42501';
  END IF;
  IF EXISTS (SELECT FROM gyrotherm.check_run r
             WHERE r.history = a_history
               AND (r.run, r.sha256) IS DISTINCT FROM (a_charts->'runs'->(r.number - 1)->>'run_id',
                                                       a_charts->'runs'->(r.number - 1)->>'sha256')) THEN
    PERFORM gyrotherm.refuse('the history lacks check runs that are there, or has others');
  END IF;
  DELETE FROM gyrotherm.check_result WHERE history = a_history;
  DELETE FROM gyrotherm.check_run WHERE history = a_history;
  INSERT INTO gyrotherm.check_run(history, number, run, started, record, sha256, verdict, explained_cause,
                                  explained_by)
  SELECT a_history, r.n, r.value->>'run_id', (r.value->>'started_utc')::timestamptz, r.value->>'record',
         r.value->>'sha256', r.value->>'verdict', e.value->>'cause', e.value->>'by'
  FROM jsonb_array_elements(a_charts->'runs') WITH ORDINALITY AS r(value, n)
  LEFT JOIN LATERAL (
    SELECT x.value FROM jsonb_array_elements(a_charts->'explanations') WITH ORDINALITY AS x(value, n)
    WHERE x.value->'run_ids' ? (r.value->>'run_id') ORDER BY x.n DESC LIMIT 1) e ON true;
  INSERT INTO gyrotherm.check_result(history, number, chart, result, unit, value, centre, low, high, q, ewma,
                                     value_is_out, ewma_is_out)
  SELECT a_history, p.n, c.n, c.value->>'result', c.value->>'unit', (p.value->>'value')::double precision,
         (p.value->>'centre')::double precision, (p.value->>'low')::double precision,
         (p.value->>'high')::double precision, (p.value->>'q')::double precision,
         (p.value->>'ewma')::double precision, (p.value->>'value_is_out')::boolean,
         (p.value->>'ewma_is_out')::boolean
  FROM jsonb_array_elements(a_charts->'charts') WITH ORDINALITY AS c(value, n),
    jsonb_array_elements(c.value->'points') WITH ORDINALITY AS p(value, n);
  UPDATE gyrotherm.check_standard
  SET cause = a_charts->'diagnosis'->>'named',
      cause_probability =
        (SELECT least(sum((h->>'probability')::double precision), 1)
         FROM jsonb_array_elements(CASE WHEN a_charts->'diagnosis'->>'named' IS NOT NULL
                                        THEN a_charts->'diagnosis'->'hypotheses' ELSE '[]' END) h
         WHERE h->>'cause' = a_charts->'diagnosis'->>'named')
  WHERE history = a_history;
  RETURN jsonb_array_length(a_charts->'runs');
END
$$;

-- The state of each check standard: its last run, open runs and the probable cause of a change. A check standard that
-- has a later history is listed with each of them.
CREATE VIEW gyrotherm.v1_check_standard AS
  SELECT s.rig, array_to_string(s.serial_numbers, ' ') AS serial_numbers, s.profile, l.verdict AS last_verdict,
         l.started AS last_run, round(extract(epoch FROM now() - l.started) / 86400) AS days_since, l.number AS runs,
         (SELECT count(*) FROM gyrotherm.check_run r
          WHERE r.history = s.history AND r.verdict = 'out of control') AS open_runs,
         s.cause, s.cause_probability, s.false_alarm_rate, s.rig_file, s.simulated, s.history
  FROM gyrotherm.check_standard s
  CROSS JOIN LATERAL (SELECT * FROM gyrotherm.check_run r WHERE r.history = s.history
                      ORDER BY r.number DESC LIMIT 1) l;

-- The control charts: each result of each check run with its limits. `q` is the deviation in standard deviations, and
-- `ewma` is in units of its limit.
CREATE VIEW gyrotherm.v1_check_chart AS
  SELECT s.rig, array_to_string(s.serial_numbers, ' ') AS serial_numbers, c.result, r.started, c.value, c.unit,
         c.centre, c.low, c.high, c.q, c.ewma,
         CASE WHEN c.q IS NULL THEN 'not judged' WHEN NOT c.value_is_out AND NOT c.ewma_is_out THEN 'in control'
              WHEN r.verdict = 'explained' THEN 'explained' ELSE 'out of control' END AS verdict,
         c.value_is_out, c.ewma_is_out, r.number, c.chart,
         r.number = max(r.number) OVER (PARTITION BY r.history) AS is_last, s.simulated, r.record, r.run, s.history
  FROM gyrotherm.check_result c
  JOIN gyrotherm.check_run r USING (history, number)
  JOIN gyrotherm.check_standard s USING (history);

REVOKE ALL ON FUNCTION gyrotherm.add_check_standard(text, text, jsonb) FROM PUBLIC;
GRANT EXECUTE ON FUNCTION gyrotherm.add_check_standard(text, text, jsonb) TO gyrotherm_rig;
GRANT SELECT ON gyrotherm.check_standard, gyrotherm.check_run, gyrotherm.check_result, gyrotherm.v1_check_standard,
  gyrotherm.v1_check_chart TO gyrotherm_analyst;
