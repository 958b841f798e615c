// Scaling over threads: measured and simulated, marked apart; what the machinery costs.
import {h, select, none, rerun, unique, whole, short, time} from "report/dom.js";
import {rowsOf} from "report/data.js";
import {colour} from "report/theme.js";
import {lineChart} from "report/chart.js";
import {picturesOf} from "report/figures.js";

/// {workload, contestant, threads, speedup, simulated}
function pointsOf(data) {
  const out = [];
  for (const p of picturesOf(data))
    for (const s of p.series ?? [])
      if (!s.strict_split && s.contestant !== "sequential" && s.speedup > 0)
        out.push({workload: p.workload, contestant: s.contestant, threads: p.threads, speedup: s.speedup, simulated: p.simulated});
  for (const bench of ["scenes", "flowgraph"])
    for (const r of rowsOf(data, bench)) {
      const speedup = r.speedup_of_sums ?? r.ratio_of_sums;
      if (speedup > 0 && r.contestant !== "sequential" && r.contestant !== "flowgraph, auto") out.push({workload: r.workload, contestant: r.contestant, threads: r.threads, speedup, simulated: false});
    }
  return out;
}

function chart(all, workload) {
  const own = all.filter((p) => p.workload === workload);
  const most = d3.max(own, (p) => p.threads);
  const series = [{name: "all there is to gain", colour: "var(--faint)", dashed: true, guide: true, points: unique([1, ...own.map((p) => p.threads)]).sort((a, b) => a - b).map((t) => [t, t])}];
  for (const name of unique(own.map((p) => p.contestant)))
    for (const simulated of [false, true]) {
      const by = d3.nest().key((p) => p.threads).rollup((list) => d3.median(list, (p) => p.speedup)).entries(own.filter((p) => p.contestant === name && p.simulated === simulated));
      const points = by.map(({key, value}) => [Number(key), value]).sort((a, b) => a[0] - b[0]);
      if (points.length > 0) series.push({name: `${name}${simulated ? ", simulated" : ""}`, group: name, strong: name === "flowgraph", colour: colour(name), dots: true, joined: points.length > 1, dashed: simulated, points});
    }
  return lineChart(series, {title: workload.replaceAll("-", " "), caption: `Times faster than sequential, in the sum over the steps. ${own.some((p) => p.simulated) ? "● measured, ○ simulated." : "All measured."}`,
    xLabel: "threads", yLabel: "times faster", xLog: most > 4, yLog: most > 4, xFormat: whole, yFormat: (v) => `${short(v)}×`, xTicks: unique(own.map((p) => p.threads)), height: 320}).element;
}

function checks(data) {
  const rows = data.results.flatMap((r) => r.validation ?? []);
  if (rows.length === 0) return null;
  return h("figure", {}, h("h3", {}, "Is the simulation right?"), h("figcaption", {}, "Predicted beside measured, where both exist."),
    h("div.scroll", {tabindex: 0}, h("table", {}, h("thead", {}, h("tr", {}, ["scene", "contestant", "threads", "measured, ms", "predicted, ms", "off by"].map((t) => h("th.text", {scope: "col"}, t)))),
      h("tbody", {}, rows.map((r) => h("tr", {}, h("td.text", {}, r.workload), h("td.text", {}, r.contestant), h("td", {}, r.threads), h("td", {}, short(r.measured_ms)), h("td", {}, short(r.predicted_ms)),
        h("td", {}, `${(100 * r.error).toFixed(1)} %`)))))));
}

function machinery(data) {
  const costs = rowsOf(data, "flowgraph").filter((r) => r.workload === "costs");
  if (costs.length === 0) return null;
  return h("figure", {}, h("h3", {}, "What the machinery costs"), h("div.scroll", {tabindex: 0}, h("table", {}, h("thead", {}, h("tr", {}, ["what", "threads", "median", "p10 to p90"].map((t) => h("th.text", {scope: "col"}, t)))),
    h("tbody", {}, costs.map((r) => h("tr", {}, h("td.text", {}, r.contestant), h("td", {}, r.threads), h("td", {}, time(r.median_ns)), h("td", {}, `${time(r.p10_ns)} to ${time(r.p90_ns)}`)))))),
    rerun("tandem-bench flowgraph --json results/flowgraph.json"));
}

function serial(data) {
  const rows = rowsOf(data, "scenes").filter((r) => r.serial_share >= 0 && r.serial_us);
  if (rows.length === 0) return null;
  const phases = ["begin", "update", "broad", "join"], threads = 64;
  const bound = (share) => 1 / (share + (1 - share) / threads);
  return h("figure.serial", {}, h("h3", {}, "What is left serial"),
    h("figcaption", {}, `What one thread does while no other can take a part, by phase, in the median step; its share in all work; and how many times faster ${threads} threads could be at most, by Amdahl's law.`),
    h("div.scroll", {tabindex: 0}, h("table", {}, h("thead", {}, h("tr", {}, ["scene", "contestant", "threads", ...phases, "share", "at most"].map((t) => h("th.text", {scope: "col"}, t)))),
      h("tbody", {}, rows.map((r) => h("tr", {}, h("td.text", {}, r.workload), h("td.text", {}, r.contestant), h("td", {}, r.threads),
        phases.map((phase) => h("td", {}, time(1000 * (r.serial_us[phase] ?? 0)))), h("td", {}, `${(100 * r.serial_share).toFixed(1)} %`), h("td", {}, `${short(bound(r.serial_share))}×`)))))),
    rerun("tandem-bench scenes --json results/scenes.json"));
}

export function scaling(section, data) {
  const all = pointsOf(data), command = "tandem-bench figures --json results/figures.json";
  if (all.length === 0) {
    section.append(none("It is measured by", command));
    return false;
  }
  section.append(h("p.lead", {}, "How much faster detection gets with threads. Filled marks were measured on this machine; open marks come from a simulator that replays the measured cost of every task on more cores."));
  const simulated = unique(all.filter((p) => p.simulated).map((p) => p.workload));
  const workloads = unique([...simulated, ...all.map((p) => p.workload)]);
  const place = h("div.grid2");
  const draw = (shown) => place.replaceChildren(...shown.map((w) => chart(all, w)));
  const first = simulated.length > 0 ? simulated : workloads.slice(0, 4);
  if (workloads.length > first.length)
    section.append(h("div.controls", {}, select("scenes", [["*", simulated.length > 0 ? "measured and simulated" : "the first four"], ...workloads.map((w) => [w, w])], "*", (v) => draw(v === "*" ? first : [v]))));
  section.append(place, rerun(command));
  draw(first);
  section.append(...[checks(data), serial(data), machinery(data)].filter(Boolean));
  return true;
}
