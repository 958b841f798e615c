// Speed against error of the narrow phase: a mark a solver.
import {h, select, time, error, none, rerun, unique, copyButton, whole, table} from "report/dom.js";
import {rowsOf} from "report/data.js";
import {colour} from "report/theme.js";
import {drawAxes, logTicks, sized, margin} from "report/chart.js";
import {showTip, hideTip} from "report/tip.js";

const floor = 1e-17;  // where an error of 0 is drawn
const bad = (r) => r.wrong > 0 || r.failed > 0;
const partial = (r) => r.unmeasured > 0;
const drawnError = (r) => Math.max(floor, r.error_p99);
const measures = (r) => !(r.unmeasured > 0 && r.unmeasured >= r.n);

/// Those that are not both slower and less exact than another; wrong verdicts, failures and what measures only some of
/// the queries are out.
function front(rows) {
  const right = rows.filter((r) => !bad(r) && !partial(r)).sort((p, q) => drawnError(p) - drawnError(q) || p.median_ns - q.median_ns);
  const out = [];
  for (const r of right) if (out.length === 0 || r.median_ns < out[out.length - 1].median_ns) out.push(r);
  return out;
}

function tipOf(r) {
  const line = (name, value) => h("tr", {}, h("td.text", {}, name), h("td", {}, value));
  return [h("b", {}, r.contestant), h("table", {},
    line("time a query", `${time(r.median_ns)} (${time(r.p10_ns)} to ${time(r.p90_ns)})`),
    line("error, p99 of the size", error(r.error_p99)), line("error, largest", error(r.error_max)),
    line("wrong verdicts", `${r.wrong} of ${whole(r.n)}`), r.failed ? line("failures", String(r.failed)) : null,
    r.unmeasured ? line("without a distance", String(r.unmeasured)) : null,
    r.wrong_normals ? line("normals off", String(r.wrong_normals)) : null)];
}

function scales(rows, width, height, m) {
  const x = d3.scaleLog().domain([floor / 3, Math.max(1e-1, d3.max(rows, drawnError) ?? 1) * 3]).range([m.left, width - m.right]);
  const [lo, hi] = d3.extent(rows, (r) => r.median_ns);
  const y = d3.scaleLog().domain([(lo ?? 10) / 1.8, (hi ?? 1e4) * 1.8]).range([height - m.bottom, m.top]);
  return {x, y};
}

const errorTick = (v) => (v <= floor * 1.01 ? "0" : `1e${Math.round(Math.log10(v))}`);

/// Places names beside marks so that none covers another or another's mark: each moves down until it is free.
function placeLabels(labels, marks) {
  labels.sort((p, q) => p.y - q.y);
  labels.forEach((label, i) => {
    const covers = (o) => Math.abs(o.y - label.y) < 13 && label.x < o.x + o.width && o.x < label.x + label.width;
    const others = marks.filter((m) => m.r !== label.r);
    for (let tries = 0; tries < 40 && (labels.slice(0, i).some(covers) || others.some(covers)); ++tries) label.y += 2;
  });
}

function bigPanel(rows, chosen, onChoose, width) {
  const height = 440;
  const {x, y} = scales(rows, width, height, margin);
  const svg = sized(width, height).attr("role", "group")
    .attr("aria-label", "Time a query over error, one mark a solver. Tab moves between marks.");
  drawAxes(svg, {x, y, width, height, xLabel: "error, 99th percentile, relative to the size →", yLabel: "time a query, logarithmic",
    xTicks: [floor, ...d3.range(-15, 2, 3).map((p) => 10 ** p).filter((v) => v < x.domain()[1])], xFormat: errorTick, yTicks: logTicks(y, 5), yFormat: time});
  svg.append("path").attr("class", "front").attr("d", d3.line().curve(d3.curveStepAfter).x((r) => x(drawnError(r))).y((r) => y(r.median_ns))(front(rows)));
  // Where there is little room only the front and the chosen are named; every mark has its tip and a line in the table.
  const leading = front(rows);
  const labels = rows.map((r) => {
    const text = r.contestant + (r.wrong ? `, ${r.wrong} wrong` : "") + (r.failed ? `, ${r.failed} failed` : "") + (r.unmeasured ? `, measures ${r.n - r.unmeasured} of ${r.n}` : "");
    const long = 6.6 * text.length, right = x(drawnError(r)) + 14 + long < width;
    return {r, text, width: long, x: right ? x(drawnError(r)) + 14 : x(drawnError(r)) - 14 - long, right, y: y(r.median_ns) + 4};
  });
  const named = width > 560 ? labels : labels.filter(({r}) => r.contestant === chosen || leading.includes(r));
  placeLabels(named, rows.map((r) => ({r, x: x(drawnError(r)) - 7, y: y(r.median_ns) + 4, width: 14})));
  for (const label of labels) {
    const {r} = label, cx = x(drawnError(r)), cy = y(r.median_ns);
    const g = svg.append("g").attr("class", `mark${r.contestant === chosen ? " chosen" : ""}`).attr("tabindex", 0).attr("role", "button")
      .attr("aria-label", `${r.contestant}: ${time(r.median_ns)} a query, error ${error(r.error_p99)}, ${r.wrong} wrong of ${r.n}`);
    g.append("circle").attr("class", "halo").attr("cx", cx).attr("cy", cy).attr("r", 11);
    g.append("circle").attr("cx", cx).attr("cy", cy).attr("r", 6).attr("fill", bad(r) || partial(r) ? "var(--card)" : colour(r.contestant)).attr("stroke", colour(r.contestant)).attr("stroke-width", 2);
    if (bad(r)) g.append("path").attr("class", "wrong").attr("d", `M${cx - 4.5},${cy - 4.5}l9,9m0,-9l-9,9`);
    if (named.includes(label)) g.append("text").attr("x", label.right ? label.x : label.x + label.width).attr("y", label.y).attr("text-anchor", label.right ? "start" : "end")
      .attr("style", bad(r) ? "fill:var(--bad)" : r.contestant.startsWith("tandem") ? "fill:var(--ink);font-weight:600" : null).text(label.text);
    g.on("click", () => onChoose(r.contestant)).on("focus", () => onChoose(r.contestant, true))
      .on("mousemove", () => showTip(d3.event.clientX, d3.event.clientY, ...tipOf(r))).on("mouseleave", hideTip);
  }
  return svg.node();
}

function smallPanel(kind, rows) {
  const width = 164, height = 104, m = {left: 5, right: 5, top: 18, bottom: 5};
  const {x, y} = scales(rows, width, height, m);
  const svg = d3.create("svg").attr("viewBox", `0 0 ${width} ${height}`).attr("width", "100%").attr("aria-hidden", "true");
  svg.append("text").attr("class", "title").attr("x", 4).attr("y", 11).text(kind);
  svg.append("line").attr("x1", 4).attr("x2", width - 4).attr("y1", height - 2).attr("y2", height - 2).attr("stroke", "var(--grid)");
  svg.append("path").attr("class", "front").attr("d", d3.line().curve(d3.curveStepAfter).x((r) => x(drawnError(r))).y((r) => y(r.median_ns))(front(rows)));
  if (rows.length === 0) svg.append("text").attr("x", 4).attr("y", 60).text("not asked of it");
  for (const r of [...rows].reverse()) {
    const cx = x(drawnError(r)), cy = y(r.median_ns);
    if (bad(r)) svg.append("path").attr("class", "wrong").attr("stroke-width", 1.5).attr("d", `M${cx - 3},${cy - 3}l6,6m0,-6l-6,6`);
    else svg.append("circle").attr("cx", cx).attr("cy", cy).attr("r", r.contestant === "tandem" ? 4 : 3).attr("fill", partial(r) ? "none" : colour(r.contestant)).attr("stroke", colour(r.contestant));
  }
  return svg.node();
}

export function accuracy(section, data) {
  const all = rowsOf(data, "narrowphase");
  if (all.length === 0) {
    section.append(none("It is measured by", "tandem-bench narrowphase --json results/narrowphase.json"));
    return false;
  }
  const kinds = unique(all.map((r) => r.kind)), classes = unique(all.map((r) => r.class)), requests = unique(all.map((r) => r.request));
  const state = {kind: kinds.includes("box-box") ? "box-box" : kinds[0], class: classes.includes("near") ? "near" : classes[0],
    request: requests.includes("distance") ? "distance" : requests[0], contestant: "tandem"};
  section.append(h("p.lead", {}, "A library that is fast and wrong is neither. Each mark is a solver: the lower, the faster; the further left, the more exact. " +
    "The dotted line is the front: nothing right is both faster and more exact. A red cross gave wrong verdicts or failed in some of the queries; an open mark measures only some of them. Errors are judged by the true signed distance in 113-bit arithmetic."));
  const controls = h("div.controls"), plot = h("div"), detail = h("div.detail", {"aria-live": "polite"}), numbers = h("details"), panels = h("div.panels", {role: "group", "aria-label": "Kinds of pairs"}), command = h("div");
  section.append(controls, h("figure", {}, plot), detail, numbers, command, h("h3", {style: "margin-top:1.3rem"}, "Every kind of pair, same class and request"), panels);

  const rowsFor = (kind) => all.filter((r) => r.kind === kind && r.class === state.class && r.request === state.request && measures(r));
  function tell() {
    const r = rowsFor(state.kind).find((row) => row.contestant === state.contestant);
    if (!r) return detail.replaceChildren("Choose a mark to see its numbers and its worst input.");
    const record = r.worst && (r.worst.shapeA ? r.worst : data.worst[r.worst.id]);
    const text = record ? JSON.stringify({...record, ask: record.ask ?? [r.request]}) : null;
    detail.replaceChildren(h("b", {}, `${r.contestant}, ${r.kind}, ${r.class}, ${r.request}: `),
      `${time(r.median_ns)} a query (${time(r.p10_ns)} to ${time(r.p90_ns)}), error ${error(r.error_p50)} in the median, ${error(r.error_p99)} at the 99th percentile, ${error(r.error_max)} at most; `,
      h(`span${bad(r) ? ".wrongtext" : ""}`, {}, `${r.wrong} wrong verdicts, ${r.failed} failures in ${whole(r.n)}`), ".",
      r.fastest_right_rival ? ` ${(1 / r.ratio_to_rival).toPrecision(2)} times as fast as the fastest other that is right, ${r.fastest_right_rival}.` : "",
      ...(text ? [h("div", {style: "margin-top:.4rem"}, `Its worst input, ${r.worst.id}, as a record for tandem query: `, copyButton(() => text, "copy record")),
        h("pre", {tabindex: 0}, text.length > 900 ? `${text.slice(0, 900)} …` : text)] : [h("div.note", {}, "Its result has no worst input; a new run of the command below records it.")]));
  }
  function draw() {
    // Requests and classes that a kind lacks give way.
    const own = all.filter((r) => r.kind === state.kind);
    if (!own.some((r) => r.request === state.request)) state.request = own[0].request;
    if (!own.some((r) => r.class === state.class && r.request === state.request)) state.class = own.find((r) => r.request === state.request).class;
    const set = (key) => (value) => { state[key] = value; draw(); };
    controls.replaceChildren(select("pair", kinds, state.kind, set("kind")), select("poses", classes, state.class, set("class")), select("asked", requests, state.request, set("request")));
    const rows = rowsFor(state.kind);
    const choose = (contestant, quiet) => { state.contestant = contestant; tell(); if (!quiet) draw(); };
    plot.replaceChildren(bigPanel(rows, state.contestant, choose, Math.max(300, plot.clientWidth || 800)));
    tell();
    numbers.replaceChildren(h("summary", {}, "The same as a table"), h("div.scroll", {tabindex: 0}, table(`${state.kind}, ${state.class}, ${state.request}`, ["solver", "time a query", "error, p99", "largest error", "wrong", "failed", "not measured"],
      [...rows].sort((p, q) => p.median_ns - q.median_ns).map((r) => [r.contestant, time(r.median_ns), error(r.error_p99), error(r.error_max), r.wrong, r.failed, r.unmeasured ?? 0]))));
    command.replaceChildren(rerun(`tandem-bench narrowphase --kind ${state.kind} --json results/narrowphase.json`));
    panels.replaceChildren(...kinds.map((kind) => h("button", {type: "button", "aria-pressed": String(kind === state.kind),
      "aria-label": `${kind}: show it large`, click: () => { state.kind = kind; draw(); }}, smallPanel(kind, rowsFor(kind)))));
  }
  draw();
  let width = plot.clientWidth;
  new ResizeObserver(() => { if (plot.clientWidth !== width) { width = plot.clientWidth; draw(); } }).observe(plot);
  return true;
}
