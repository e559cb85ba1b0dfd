-- SPDX-License-Identifier: Apache-2.0
-- Units by run: the position and the serial number of each unit, and the order of the run.

CREATE OR REPLACE VIEW gyrotherm.v1_run AS
  SELECT id AS run, rig, started, profile, simulated, state, cause, finished, ended, rows, gaps,
         gyrotherm.utc(last_utc_ns) AS last_row, chain_head,
         files->0->>'sha256' AS sha256, (files->0->>'bytes')::bigint AS bytes, dropped,
         info->>'order_number' AS order_number
  FROM gyrotherm.run;

-- A run without an order has no order number.
CREATE VIEW gyrotherm.v1_unit AS
  SELECT u.serial_number, u.model, r.info->>'order_number' AS order_number, r.rig, u.label AS position, r.profile,
         r.started, r.state, r.finished, r.simulated, r.id AS run
  FROM gyrotherm.run_unit u JOIN gyrotherm.run r ON r.id = u.run;

GRANT SELECT ON gyrotherm.v1_unit TO gyrotherm_analyst;
