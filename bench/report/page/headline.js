// The scenes by executor: ratios large, times small.
import {h, time, whole, none, rerun, unique, ratio as ratioText} from "report/dom.js";
import {rowsOf} from "report/data.js";

const order = ["sequential", "barrier", "fused", "threads", "flowgraph", "flowgraph, auto"];
/// Sequential steps on all cores at once, which share nothing: what the cores give at all.
const isCeiling = (name) => /^\d+ copies$/.test(name);
const explained = {
  barrier: "both phases parallel, a barrier between",
  fused: "each tile of the broad phase narrows its own pairs",
  threads: "the paper’s design on std::thread",
  flowgraph: "both phases at once, balanced",
  "flowgraph, auto": "the default: the broad phase is chosen",
};

/// A large ratio with its bar and, small, the time behind it.
function cell(name, row, ratio, most, kind, ...notes) {
  if (!row) return h("td", {"data-name": name}, "–");
  return h(`td${kind ? `.${kind}` : ""}`, {"data-name": name},
    h("div.ratio", {}, ratioText(ratio), h("small", {}, "×")),
    h("span.bar", {}, h("i", {style: `width:${(100 * ratio) / most}%`})),
    h("span.ms", {title: `p10 ${time(row.p10_ns)}, p90 ${time(row.p90_ns)}`}, time(row.median_ns)), ...notes);
}

function scenesTable(caption, names, titles, rows) {
  return h("div.wide", {tabindex: 0, role: "group", "aria-label": caption}, h("table.scenes", {}, h("caption", {}, caption),
    h("thead", {}, h("tr", {}, h("th.text", {scope: "col"}, "scene"), names.map((name, i) => h("th", {scope: "col", title: titles[i]}, name)))),
    h("tbody", {}, rows)));
}

const rowHead = (workload, ...facts) => h("th", {scope: "row"}, workload.replaceAll("-", " "), facts);
/// What a contestant does not find of the pairs that touch, in words; null when it finds all.
function missed(r) {
  if (!(r?.pairs_missed > 0)) return null;
  const part = (100 * r.pairs_missed) / Math.max(1, r.pairs - (r.pairs_extra ?? 0) + r.pairs_missed);
  return h("span.missed", {}, `misses ${part < 0.01 ? `${whole(r.pairs_missed)} pairs` : `${part.toPrecision(2)} %`}`);
}

function peers(section, data) {
  const rows = rowsOf(data, "peers");
  if (rows.length === 0) return false;
  const ours = (r) => r.contestant.startsWith("tandem");
  const nameOf = (r) => r.contestant + (r.threads > 1 ? `, ${r.threads} threads` : "");
  const names = [...unique(rows.filter(ours).map(nameOf)), ...unique(rows.filter((r) => !ours(r)).map(nameOf)).sort()];
  const workloads = unique(rows.map((r) => r.workload)).map((workload) => {
    const own = rows.filter((r) => r.workload === workload);
    const others = own.filter((r) => !ours(r)).map((r) => r.median_ns);
    const reference = others.length > 0 ? Math.min(...others) : own[0].median_ns;
    return {workload, own, reference, most: Math.max(...own.map((r) => reference / r.median_ns))};
  });
  section.append(h("figure", {}, h("h3", {}, "Beside other libraries"),
    scenesTable("The whole step on the same recorded poses, contacts computed: how many times faster than the fastest other library, and the median time. Kept: answers of pairs that hardly moved are kept, with a bound.",
      names, [], workloads.map(({workload, own, reference, most}) => h("tr", {}, rowHead(workload, h("span", {}, `${whole(own[0].n)} bodies, ${own[0].steps ?? own[0].samples} steps`)),
        names.map((name) => {
          const r = own.find((x) => nameOf(x) === name);
          return cell(name, r, r ? reference / r.median_ns : 0, most, r && (ours(r) ? "best" : "base"), missed(r) ?? "");
        })))),
    rerun("tandem-bench peers --json results/peers.json")));
  return true;
}

export function headline(section, data) {
  const all = rowsOf(data, "scenes");
  if (all.length === 0) {
    section.append(none("They are measured by", "tandem-bench scenes --json results/scenes.json"));
    return peers(section, data);
  }
  const most = Math.max(...all.map((r) => r.ratio_to_sequential ?? 1));
  const present = unique(all.map((r) => r.contestant)), ceilings = present.filter(isCeiling);
  const contestants = unique([...order.filter((name) => present.includes(name)), ...present.filter((name) => !isCeiling(name)), ...ceilings]);
  const threads = Math.max(...all.map((r) => r.threads));
  const measured = all.filter((r) => r.threads === threads || r.contestant === "sequential");
  const workloads = unique(measured.map((r) => r.workload));
  section.append(h("p.lead", {}, `How many times faster than one thread a step of detection is on ${threads} threads. ` +
    "All detect on the same poses in turn and find the same contacts, bit for bit. All but auto use the paper’s brute-force broad phase."));
  section.append(scenesTable(`Times faster than sequential, and the median time a step; ${threads} threads.`, contestants, contestants.map((name) => (isCeiling(name) ? "independent sequential steps, one a core: what the cores give" : explained[name])), workloads.map((workload) => {
    const rows = measured.filter((r) => r.workload === workload);
    const hashes = unique(rows.map((r) => r.hash));
    return h("tr", {}, rowHead(workload, h("span", {}, `${whole(rows[0].n)} bodies, ${rows[0].steps ?? rows[0].samples} steps`),
      h("span", {title: hashes.join(" ")}, hashes.length === 1 ? "contacts equal, to the bit" : "contacts differ")),
    contestants.map((name) => {
      const r = rows.find((x) => x.contestant === name);
      return cell(name, r, r?.ratio_to_sequential ?? 1, most, name === "sequential" || isCeiling(name) ? "base" : name === "flowgraph, auto" ? "best" : "");
    }));
  })));
  if (ceilings.length > 0) section.append(h("p.note", {}, h("b", {}, `${ceilings.join(", ")}: `), "as many sequential steps at once, each alone on its core and sharing nothing. It is what these cores give to any way of dividing the same work; auto does less work."));
  section.append(h("p.note", {}, h("b", {}, "December 2010: "), "on two cores of that time the paper (Avril, Gouranton, Arnaldi, ICAT 2010) reached 1.65, 1.42 and 1.67 times its sequential step on scenes of the same kind, " +
    "with a brute-force broad phase and a narrow phase of its own. Its times are not comparable with these, its ratios are."));
  section.append(rerun("tandem-bench scenes --json results/scenes.json"));
  peers(section, data);
  return true;
}
