-- SPDX-License-Identifier: Apache-2.0
-- What a report says counts until whoever sent it replaces it. Before, a report of the same number and unit did so
-- whoever sent it, and a rig could make another one's calibrations disappear.

CREATE OR REPLACE VIEW gyrotherm.current_calibration AS
  SELECT c.* FROM gyrotherm.calibration c JOIN gyrotherm.document d USING (sha256)
  WHERE c.state <> 'superseded' AND NOT EXISTS (
    SELECT FROM gyrotherm.calibration o JOIN gyrotherm.document p USING (sha256)
    WHERE o.serial_number = c.serial_number AND o.model = c.model AND (p.owner = d.owner OR c.state = 'draft')
      AND (o.state = 'superseded' AND o.number = c.number AND c.number <> ''
           OR o.state <> 'superseded' AND o.calibrated = c.calibrated AND (o.number = c.number OR c.state = 'draft')
              AND (o.state, o.sha256) < (c.state, c.sha256)));

SELECT gyrotherm.make_drift(serial_number, model) FROM gyrotherm.unit ORDER BY serial_number, model;
