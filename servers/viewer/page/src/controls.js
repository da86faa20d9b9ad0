// SPDX-License-Identifier: BSD-3-Clause
// Buttons, boxes and keys of the page, and its theme.
const $ = (id) => document.getElementById(id);

function setTheme(page, theme) {
  document.documentElement.dataset.theme = theme;
  try { localStorage.setItem("theme", theme); } catch { /* kept for this page alone */ }
  page.stage.setTheme();
  for (const chart of page.charts) chart.reset();
}

function takeKey(page, event) {
  const typing = /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName) && event.target.type !== "checkbox" && event.target.type !== "range";
  if (typing || event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
  // On a button or a box the space bar is that button's.
  if (event.key === " " && /^(BUTTON|INPUT|SUMMARY)$/.test(event.target.tagName)) return;
  const keys = {
    " ": () => (page.live ? $(page.run?.phase === "RUN_PAUSED" ? "resume" : "pause") : $("play")).click(),
    ArrowRight: () => $(page.live ? "step" : "forward").click(),
    ArrowLeft: () => { if (!page.live) $("back").click(); },
    r: () => { if (page.live) $("reset").click(); else page.seek(0); },
    f: () => page.stage.lookAtRobot(),
    c: () => $("add-chart").click(),
    t: () => $("theme").click(),
    p: () => { if (page.pusher.enabled) $("push").click(); },
    v: () => { if (page.recorder.isPossible) $("record").click(); },
    "?": () => $("help").click(),
  };
  const action = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!action || (event.target.type === "range" && event.key.startsWith("Arrow"))) return;
  event.preventDefault();
  action();
}

export function listenTo(page) {
  $("pause").onclick = () => page.request("pause");
  $("resume").onclick = () => page.request("run");
  $("step").onclick = () => page.request("step", { steps: Number($("steps").value) });
  $("reset").onclick = () => page.request("reset");
  $("speed").onchange = () => { if (page.run?.phase === "RUN_RUNNING") page.request("run"); };
  $("speed").value = "1";
  $("play").onclick = () => { page.player.toggle(); page.showTransport(); };
  $("back").onclick = () => page.player.step(-1);
  $("forward").onclick = () => page.player.step(1);
  $("scrub").oninput = () => page.seek(Number($("scrub").value));
  $("play-speed").onchange = () => { page.player.speed = Number($("play-speed").value); };
  $("run-a").onchange = () => page.choose(Number($("run-a").value), page.chosen[1]);
  $("run-b").onchange = () => page.choose(page.chosen[0], Number($("run-b").value));
  $("add-chart").onclick = () => page.addChart();
  $("help").onclick = () => $("help-dialog").showModal();
  $("push").onclick = () => page.togglePush();
  $("record").hidden = !page.recorder.isPossible;
  $("record").onclick = () => page.toggleVideo();
  $("theme").onclick = () => setTheme(page, page.theme() === "dark" ? "light" : "dark");
  for (const box of document.querySelectorAll("[data-layer]")) {
    box.onchange = () => { page.stage.layers[box.dataset.layer] = box.checked; page.stage.dirty = true; };
  }
  $("scan-box").onchange = () => page.showScans();
  addEventListener("keydown", (event) => takeKey(page, event));
  let theme = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
  try { theme = localStorage.getItem("theme") ?? theme; } catch { /* a browser that keeps nothing */ }
  document.documentElement.dataset.theme = theme;
}
