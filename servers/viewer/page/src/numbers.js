// SPDX-License-Identifier: BSD-3-Clause
// What the page says in numbers and words: time, feet, the run and its servers.
import { norm } from "./forces.js";

const $ = (id) => document.getElementById(id);
const phases = { RUN_WAITING: "waiting for servers", RUN_RUNNING: "running", RUN_PAUSED: "paused", RUN_FINISHED: "finished", RUN_FAILED: "failed" };

function showFeet(feet) {
  const body = $("feet").tBodies[0];
  while (body.rows.length > feet.length) body.deleteRow(-1);
  feet.forEach((foot, i) => {
    const row = body.rows[i] ?? body.insertRow();
    while (row.cells.length < 5) row.insertCell();
    const number = (value) => (foot.touching && Number.isFinite(value) ? value.toFixed(1) : foot.sensor ? "–" : "0.0");
    const texts = [foot.name, number(foot.total[2]), ...["spring", "damper"].map((part) => number(foot[part]?.[2] ?? NaN)),
                   number(foot.friction ? norm(foot.friction) : NaN)];
    texts.forEach((text, column) => { row.cells[column].textContent = text; });
    row.className = foot.touching ? "" : "air";
    row.dataset.foot = foot.name;
  });
}

export function showNumbers(topics, stage) {
  const header = topics["hrp/robot_state"]?.header ?? topics["hrp/sensor_data"]?.header;
  if (header) $("time").textContent = header.time.toFixed(3);
  showFeet(stage.feet);
  const zmp = stage.zmps[0] ?? null;
  $("zmp").textContent = zmp ? `${zmp[0].toFixed(4)}, ${zmp[1].toFixed(4)}` : "–";
  const step = topics["hrp/contact_forces"]?.header.step;
  $("forces-step").textContent = step === undefined ? "" : `· forces of step ${step}`;
  $("forces-step").dataset.step = step ?? "";
}

// Of a recording, from the fall on; a live run says it beside its phase.
export function showFall(event) {
  $("late").hidden = event?.kind !== "EVENT_FALL";
  $("late").textContent = event ? `fell at ${event.header.time.toFixed(3)} s` : "";
}

// `control`: the page may steer the run.
export function showRun(run, control) {
  $("factor").textContent = `${run.real_time_factor.toFixed(2)} ×`;
  $("late").hidden = run.late === "";
  $("late").textContent = run.late ? `waits for ${run.late}` : "";
  $("phase").textContent = phases[run.phase] + (run.message ? `: ${run.message}` : "");
  const over = run.phase === "RUN_FINISHED" || run.phase === "RUN_FAILED";
  for (const id of ["pause", "resume", "step", "reset"]) $(id).disabled = !control || over;
  $("pause").classList.toggle("primary", run.phase === "RUN_RUNNING");
  $("resume").classList.toggle("primary", run.phase === "RUN_PAUSED");
}

// `current`: they are of this moment.
export function showServers(servers, current) {
  $("servers").classList.toggle("old", !current);
  $("servers-note").hidden = current;
  $("servers").tBodies[0].replaceChildren(...Object.values(servers).map((server) => {
    const row = document.createElement("tr");
    for (const text of [server.server, server.program, server.phase.replace("SERVER_", "").toLowerCase(), server.step, server.waiting_for]) {
      row.insertCell().textContent = text;
    }
    return row;
  }));
}
