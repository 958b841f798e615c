// The scenes by executor: ratios large, times small.
import {h, time, whole, none, rerun, table, unique, short} from "report/dom.js";
import {rowsOf} from "report/data.js";

const order = ["sequential", "barrier", "threads", "flowgraph", "flowgraph, auto"];
const explained = {
  barrier: "both phases parallel, a barrier between",
  threads: "the paper’s design on std::thread",
  flowgraph: "both phases at once, balanced",
  "flowgraph, auto": "the default: the broad phase is chosen",
};

function cell(row, most) {
  if (!row) return h("td", {}, "–");
  const ratio = row.ratio_to_sequential ?? 1;
  const base = row.contestant === "sequential";
  return h(`td${base ? ".base" : row.contestant === "flowgraph, auto" ? ".best" : ""}`, {},
    h("div.ratio", {}, base ? "1" : short(Math.round(ratio * 100) / 100), h("small", {}, "×")),
    h("span.bar", {style: "width:100%"}, h("i", {style: `width:${(100 * ratio) / most}%`})),
    h("span.ms", {title: `p10 ${time(row.p10_ns)}, p90 ${time(row.p90_ns)}`}, time(row.median_ns)));
}

function peers(section, data) {
  const rows = rowsOf(data, "peers");
  if (rows.length === 0) return;
  section.append(h("figure", {}, h("h3", {}, "Beside other libraries"),
    h("div.scroll", {}, table("The whole step on recorded poses, contacts computed.", ["scene", "contestant", "threads", "ms a step", "p10 to p90"],
      rows.map((r) => [r.workload, r.contestant, r.threads, short(r.median_ns / 1e6), `${short(r.p10_ns / 1e6)} to ${short(r.p90_ns / 1e6)}`]))),
    rerun("tandem-bench peers --json results/peers.json")));
}

export function headline(section, data) {
  const all = rowsOf(data, "scenes");
  if (all.length === 0) {
    section.append(none("They are measured by", "tandem-bench scenes --json results/scenes.json"));
    peers(section, data);
    return false;
  }
  const most = Math.max(...all.map((r) => r.ratio_to_sequential ?? 1));
  const contestants = unique([...order.filter((name) => all.some((r) => r.contestant === name)), ...all.map((r) => r.contestant)]);
  const threads = Math.max(...all.map((r) => r.threads));
  const measured = all.filter((r) => r.threads === threads || r.contestant === "sequential");
  const workloads = unique(measured.map((r) => r.workload));
  section.append(h("p.lead", {}, `How many times faster than one thread a step of detection is on ${threads} threads, and below it the time a step, in the median. ` +
    "All detect on the same poses in turn and find the same contacts, bit for bit. The first four use the paper’s brute-force broad phase."));
  section.append(h("table.scenes", {}, h("thead", {}, h("tr", {}, h("th.text", {scope: "col"}, "scene"),
    contestants.map((name) => h("th", {scope: "col", title: explained[name]}, name)))),
  h("tbody", {}, workloads.map((workload) => {
    const rows = measured.filter((r) => r.workload === workload);
    const hashes = unique(rows.map((r) => r.hash));
    return h("tr", {}, h("th", {scope: "row"}, workload.replaceAll("-", " "),
      h("span", {}, `${whole(rows[0].n)} bodies, ${rows[0].steps ?? rows[0].samples} steps`),
      h("span", {title: hashes.join(" ")}, hashes.length === 1 ? "contacts equal" : "contacts differ")),
    contestants.map((name) => cell(rows.find((r) => r.contestant === name), most)));
  }))));
  section.append(h("p.note", {}, "The paper, 2010, on two cores of its time, scenes of the same kind: 1.42 to 1.67 times faster than sequential, " +
    "brute-force broad phase, its own narrow phase. Its times are not comparable, its ratios are."));
  section.append(rerun("tandem-bench scenes --json results/scenes.json"));
  peers(section, data);
  return true;
}
