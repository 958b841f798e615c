// Broad phases: cost over bodies, methods and peers; the worlds made to break them.
import {h, select, time, none, rerun, unique, whole, brief, ratio} from "report/dom.js";
import {rowsOf} from "report/data.js";
import {colour} from "report/theme.js";
import {lineChart, logTicks, legend, sized} from "report/chart.js";
import {showTip, hideTip} from "report/tip.js";

const costs = {
  cpu_mean_ns: "processor time a step, mean",
  cpu_median_ns: "processor time a step, median",
  median_ns: "wall time a step, median",
  max_ns: "longest step",
  first_step_ns: "first step",
};

/// Worlds as rows, contestants as marks, at one size each.
function strip(rows, worlds, cost, width) {
  const row = 27, long = width > 760, left = long ? 400 : 78, height = worlds.length * row + 34;
  const [lo, hi] = d3.extent(rows, (r) => r[cost]);
  const x = d3.scaleLog().domain([lo / 1.3, hi * 1.3]).range([left, width - 14]);
  const svg = sized(width, height).attr("role", "img").attr("aria-label", "Cost a step by world, a mark a contestant");
  svg.append("g").attr("transform", `translate(0,${height - 26})`).call(d3.axisBottom(x).tickValues(logTicks(x)).tickFormat(time).tickSize(-(height - 32)).tickPadding(7)).select(".domain").remove();
  worlds.forEach((world, i) => {
    const own = rows.filter((r) => r.workload === world.name), y = i * row + 14;
    if (own.length === 0) return;
    svg.append("line").attr("x1", x(d3.min(own, (r) => r[cost]))).attr("x2", x(d3.max(own, (r) => r[cost]))).attr("y1", y).attr("y2", y).attr("stroke", "var(--line)").attr("stroke-width", 2);
    svg.append("text").attr("x", 0).attr("y", y + 4).attr("style", "fill:var(--ink)").attr("font-weight", 600).text(world.name).append("title").text(world.text);
    if (long) svg.append("text").attr("x", 78).attr("y", y + 4).text(world.text);
    for (const r of own) {
      const ours = r.contestant.startsWith("tandem");
      svg.append("circle").attr("cx", x(r[cost])).attr("cy", y).attr("r", r.contestant.includes("auto") ? 6 : 4.5)
        .attr("fill", ours ? colour(r.contestant) : "var(--card)").attr("stroke", r.agrees === false ? "var(--bad)" : colour(r.contestant)).attr("stroke-width", 2)
        .on("mousemove", () => showTip(d3.event.clientX, d3.event.clientY, h("b", {}, r.contestant), h("div", {}, `${world.name}: ${world.text}`), h("div", {}, `${whole(r.n)} boxes, ${whole(r.pairs ?? 0)} pairs: ${time(r[cost])}`), r.agrees === false ? h("div.wrongtext", {}, "found other pairs") : ""))
        .on("mouseleave", hideTip);
    }
  });
  return svg.node();
}

/// Where the default stands against the fastest other library, at the most boxes that both were given.
function ahead(rows, cost) {
  const ours = rows.filter((r) => r.contestant === "tandem auto"), others = rows.filter((r) => !r.contestant.startsWith("tandem"));
  const n = d3.max(ours.filter((r) => others.some((o) => o.n === r.n)), (r) => r.n);
  if (n === undefined) return null;
  const other = others.filter((o) => o.n === n).sort((p, q) => p[cost] - q[cost])[0];
  return {n, other: other.contestant, times: other[cost] / ours.find((r) => r.n === n)[cost]};
}

export function broadphase(section, data) {
  const all = rowsOf(data, "broadphase");
  if (all.length === 0) {
    section.append(none("It is measured by", "tandem-bench broadphase --json results/broadphase.json"));
    return false;
  }
  const named = new Map(data.worlds.map((w) => [w.name, w]));
  const worlds = unique(all.map((r) => r.workload)).map((name) => named.get(name) ?? {name, text: "", breaking: false});
  const typical = worlds.filter((w) => !w.breaking), breaking = worlds.filter((w) => w.breaking);
  const threads = unique(all.map((r) => r.threads)).sort((a, b) => a - b);
  const known = Object.keys(costs).filter((key) => all.some((r) => r[key] !== undefined));
  const state = {threads: threads[0], cost: known[0]};
  section.append(h("p.lead", {}, "Boxes are given anew each step: update, and report every pair that overlaps. All contestants find the same pairs. The lower, the faster."));
  const controls = h("div.controls"), names = h("div"), plots = h("div.grid2"), hard = h("div"), hidden = new Set();
  section.append(controls, names, plots, hard, rerun("tandem-bench broadphase --json results/broadphase.json"));
  function draw() {
    const rows = all.filter((r) => r.threads === state.threads && r[state.cost] > 0);
    controls.replaceChildren(select("cost", known.map((k) => [k, costs[k]]), state.cost, (v) => { state.cost = v; draw(); }),
      threads.length > 1 ? select("threads", threads.map(String), String(state.threads), (v) => { state.threads = Number(v); draw(); }) : "");
    const curves = typical.map((world) => {
      const own = rows.filter((r) => r.workload === world.name);
      if (own.length === 0) return null;
      const lead = ahead(own, state.cost);
      const series = unique(own.map((r) => r.contestant)).map((name) => ({name, colour: colour(name), dots: true, joined: true, strong: name === "tandem auto",
        points: own.filter((r) => r.contestant === name).sort((p, q) => p.n - q.n).map((r) => [r.n, r[state.cost]])}));
      return lineChart(series, {title: lead ? [`${world.name}: `, h("span.big", {}, `${ratio(lead.times)}×`)] : world.name, hidden,
        caption: world.text + (lead ? `. At ${brief(lead.n)} boxes tandem auto is ${ratio(lead.times)} times as fast as the fastest other, ${lead.other}.` : "."), label: `Broad phase, world ${world.name}: ${costs[state.cost]} over boxes`, xLabel: "boxes", yLabel: costs[state.cost], xLog: true, yLog: true, xFormat: brief, yFormat: time, height: 290});
    }).filter(Boolean);
    const present = unique(typical.flatMap((world) => rows.filter((r) => r.workload === world.name).map((r) => r.contestant)));
    names.replaceChildren(legend(present.map((name) => ({name, colour: colour(name)})), hidden, () => curves.forEach((c) => c.draw())));
    plots.replaceChildren(...curves.map((c) => c.element));
    hard.replaceChildren();
    const own = rows.filter((r) => breaking.some((w) => w.name === r.workload));
    if (own.length === 0) return;
    // Of each world the largest size that every contestant was measured at.
    const chosen = breaking.flatMap((world) => {
      const here = own.filter((r) => r.workload === world.name), size = unique(here.map((r) => r.n)).sort((p, q) => here.filter((r) => r.n === q).length - here.filter((r) => r.n === p).length || q - p)[0];
      return here.filter((r) => r.n === size);
    });
    const place = h("div");
    hard.append(h("figure", {}, h("h3", {}, "Worlds made to break a broad phase"),
      h("figcaption", {}, `A row a world, a mark a contestant, at ${unique(chosen.map((r) => r.n)).map(whole).join(" or ")} boxes; open marks are other libraries, a red rim found other pairs. What matters is that the large mark, the default, never lies far right.`),
      h("ul.legend", {}, unique(chosen.map((r) => r.contestant)).map((name) => h("li", {}, h("i.dot", {"--c": colour(name)}), ` ${name}`))), place));
    place.replaceChildren(strip(chosen, breaking.filter((w) => chosen.some((r) => r.workload === w.name)), state.cost, Math.max(300, place.clientWidth || 800)));
  }
  draw();
  let width = plots.clientWidth;
  new ResizeObserver(() => { if (plots.clientWidth !== width) { width = plots.clientWidth; draw(); } }).observe(plots);
  return true;
}
