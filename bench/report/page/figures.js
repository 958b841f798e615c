// The paper's Figures 3 to 7, from the pictures of `tandem-bench figures`.
import {h, select, checkbox, none, rerun, whole, short, unique} from "report/dom.js";
import {colour} from "report/theme.js";
import {lineChart} from "report/chart.js";

export const picturesOf = (data) => data.results.flatMap((r) => (r.pictures ?? []).map((p) => ({...p, file: r.file})));
const nameOf = (p) => `${p.workload}, ${p.threads} threads, ${p.simulated ? "simulated" : "measured"}`;

/// Medians over a window: single steps are disturbed by whatever else the machine does.
const smoothed = (values, on) => (on ? values.map((_, i) => d3.median(values.slice(Math.max(0, i - 4), i + 5))) : values);
const points = (values, on) => smoothed(values, on).map((y, x) => [x, y]);

function curve(series, smooth, dashed) {
  return {name: series.contestant, colour: colour(series.contestant), dashed, points: points(series.ms, smooth)};
}
const steps = {xLabel: "step", xFormat: whole, yLabel: "ms a step"};

/// What became of a rule's decision: the next look verifies a change.
function verdict(d, later) {
  if (d.action !== "change") return null;
  const look = later.find((x) => x.action === "confirm" || x.action === "revert");
  if (!look) return h("span", {}, "not verified before the end");
  const kept = look.action === "confirm";
  return h(`span.${kept ? "good" : "wrongtext"}`, {}, `${kept ? "kept" : "taken back"}: ${short(look.measure)} after ${short(look.measure_before)}`);
}

function decisionLog(series) {
  const looks = series.decisions.filter((d) => d.action !== "none");
  const rows = looks.map((d, i) => h("tr", {title: d.reason}, h("td", {}, d.step), h("td", {}, `${short(d.broad_ms)} + ${short(d.narrow_ms)}`),
    h("td.text", {}, d.before === d.after ? `${d.action} ${d.after}` : `${d.action} ${d.before} → ${d.after}`),
    h("td.text", {}, verdict(d, looks.slice(i + 1)) ?? "–"), h("td", {}, d.control_step)));
  return h("figure", {}, h("h3", {}, `The decision log: ${series.contestant}`), h("figcaption", {}, `${looks.length} looks at the balance: what was measured, what was decided, whether the verification kept it (what it compares after and before).`),
    h("div.scroll", {tabindex: 0}, h("table", {}, h("thead", {}, h("tr", {}, ["step", "broad + narrow, ms", "decided", "verified", "next look"].map((t) => h("th.text", {scope: "col"}, t)))), h("tbody", {}, rows))));
}

/// Figure 3: the split of each rule, and one rule's log beside it.
function splits(p) {
  const dynamic = p.series.filter((s) => s.broad_threads && s.decisions?.length > 0);
  const place = h("div.beside");
  const draw = (rule) => {
    const chosen = dynamic.find((s) => s.contestant === rule);
    const marks = chosen.decisions.filter((d) => d.action === "change" || d.action === "revert").map((d) => ({x: d.step, colour: d.action === "revert" ? "var(--bad)" : "var(--faint)"}));
    const notes = (x) => dynamic.flatMap((s) => s.decisions.filter((d) => d.step === x && d.action !== "none").map((d) => `${s.contestant}: ${d.action}, ${d.reason}`));
    place.replaceChildren(lineChart(dynamic.map((s) => ({name: s.contestant, colour: colour(s.contestant), step: true, strong: s === chosen, points: points(s.broad_threads)})),
      {title: nameOf(p), caption: `Threads of the broad phase. Dotted: ${rule} changed its split; red: it took a change back.`, xLabel: "step", xFormat: whole, yLabel: "broad threads", yFormat: whole, marks, notes, height: 330}).element, decisionLog(chosen));
  };
  if (dynamic.length === 0) return h("p.note", {}, "No decisions were recorded.");
  draw(dynamic[0].contestant);
  return h("div", {}, dynamic.length > 1 ? h("div.controls", {}, select("log of", dynamic.map((s) => s.contestant), dynamic[0].contestant, draw)) : null, place);
}

const makers = {
  3: {title: "Figure 3: the split over the control steps", many: true, draw: splits},
  4: {title: "Figure 4: one simulation that switches between sequential and parallel", draw(p, smooth) {
    const modes = unique(p.mode);
    const most = d3.quantile([...p.ms].sort((a, b) => a - b), 0.995);
    return lineChart(modes.map((mode) => ({name: mode, colour: colour(mode), dots: true, points: p.ms.map((ms, i) => [i, Math.min(ms, most)]).filter((_, i) => p.mode[i] === mode)})),
      {...steps, title: nameOf(p), caption: "A dot a step, in the colour of what ran it."}).element;
  }},
  5: {title: "Figure 5: time a step, sequential against parallel", draw(p, smooth) {
    return lineChart(p.series.filter((s) => s.ms && ["sequential", "threads", "flowgraph", "barrier", "fused"].includes(s.contestant)).map((s) => curve(s, smooth, p.simulated)), {...steps, title: nameOf(p),
      caption: `${whole(p.bodies)} bodies. In the sum over the steps: ${p.series.filter((s) => ["threads", "flowgraph"].includes(s.contestant)).map((s) => `${s.contestant} ${s.speedup.toFixed(2)}×`).join(", ")}.`}).element;
  }},
  6: {title: "Figure 6: the dynamic split against the best strict split of each step", many: true, draw(p, smooth) {
    const dynamic = p.series.filter((s) => s.ms && ["flowgraph", "strict, paper rule", "strict, busy rule"].includes(s.contestant));
    return lineChart([...dynamic.map((s) => curve(s, smooth, p.simulated)), {name: "best strict split of the step", colour: "var(--ink)", dashed: true, points: points(p.oracle_ms, smooth)}],
      {...steps, title: nameOf(p), caption: `Sum over the sum of the best: ${dynamic.map((s) => `${s.contestant} ${s.over_oracle.toFixed(3)}`).join("; ")}. Below 1 is better than any strict split could be.`}).element;
  }},
  7: {title: "Figure 7: every strict split, the dynamic ones, and the best of each step", many: true, draw(p) {
    const splits = p.series.filter((s) => s.strict_split), broad = splits.map((s) => Number(s.contestant.split(" ")[1].split("-")[0]));
    const x = d3.extent(broad), wide = x[0] === x[1] ? [x[0] - 0.5, x[1] + 0.5] : x;
    const level = (name, ms, tint, dashed) => ({name, colour: tint, dashed, points: [[wide[0], ms], [wide[1], ms]]});
    return lineChart([{name: "strict X-Y", colour: "var(--s-7)", dots: true, joined: true, points: splits.map((s, i) => [broad[i], s.sum_ms])}, level("best of each step", p.oracle_sum_ms, "var(--ink)", true),
      ...p.series.filter((s) => !s.strict_split && s.contestant !== "sequential").map((s) => level(s.contestant, s.sum_ms, colour(s.contestant)))],
    {title: nameOf(p), caption: "ms in all steps, logarithmic; levels are contestants without a fixed split.", xLabel: "threads of the broad phase", xFormat: whole, yLabel: "ms in all", yLog: true, height: 330}).element;
  }},
};

function figure(number, pictures, smooth) {
  const own = pictures.filter((p) => p.figures.includes(number) && (p.series ? p.series.length > 0 : true));
  if (own.length === 0) return null;
  const maker = makers[number], place = h("div");
  const draw = (i) => place.replaceChildren(maker.draw(own[i], smooth));
  // On two threads there is one split: where splits are compared, a picture of the paper's eight threads comes first.
  const first = maker.many ? Math.max(0, own.findIndex((p) => p.threads >= 8)) : 0;
  const out = h("div", {id: `figure-${number}`, style: "margin-top:1.6rem"}, h("h3", {}, maker.title),
    own.length > 1 ? h("div.controls", {}, select("scene and threads", own.map((p, i) => [String(i), nameOf(p)]), String(first), (v) => draw(Number(v)))) : null, place);
  draw(first);
  return out;
}

export function figures(section, data) {
  const command = "tandem-bench figures --json results/figures.json";
  const pictures = picturesOf(data);
  if (pictures.length === 0) {
    section.append(none("They are measured by", command));
    return false;
  }
  section.append(h("p.lead", {}, "Hover or use the arrow keys to read a step; drag to zoom, double-click to see all again. Solid curves were measured on this machine’s cores, " +
    "dashed ones are a simulation that replays the measured cost of every task on more."));
  const place = h("div");
  const draw = (smooth) => place.replaceChildren(...["3", "4", "5", "6", "7"].map((n) => figure(n, pictures, smooth)).filter(Boolean));
  section.append(h("div.controls", {}, checkbox("medians over nine steps", true, draw)), place, rerun(command));
  draw(true);
  return true;
}
