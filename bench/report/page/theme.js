// Colours: one for each contestant, the same in every section, light and dark.

const own = ["tandem", "flowgraph", "flowgraph, auto", "tandem automatic", "tandem auto", "dynamic, work conserved"];
const fixed = new Map([
  ...own.map((name) => [name, "--s-1"]),
  ["sequential", "--s-7"], ["barrier", "--s-2"], ["threads", "--s-3"], ["threads, dynamic", "--s-3"],
  ["tandem, warm", "--s-8"], ["tandem, gjk", "--s-10"], ["tandem, tolerance 1e-3", "--s-3"],
  ["FCL", "--s-2"], ["FCL OBBRSS", "--s-2"], ["FCL tree", "--s-2"], ["FCL unsigned", "--s-9"],
  ["tandem grid", "--s-10"], ["tandem bvh", "--s-8"], ["tandem sweep", "--s-3"], ["tandem brute", "--s-7"],
  ["Embree refit", "--s-5"], ["Embree rebuild", "--s-9"], ["Bullet dbvt", "--s-4"], ["CGAL boxes", "--s-6"],
  ["fused", "--s-4"], ["strict, paper rule", "--s-6"], ["strict, busy rule", "--s-8"],
  ["libccd GJK+EPA", "--s-4"], ["libccd MPR", "--s-6"],
]);
const spare = ["--s-5", "--s-9", "--s-4", "--s-6", "--s-8", "--s-10", "--s-2", "--s-3", "--s-7"];
let next = 0;

/// The CSS colour of a contestant.
export function colour(name) {
  if (name.endsWith(" copies")) return "var(--ink)";
  if (!fixed.has(name)) fixed.set(name, spare[next++ % spare.length]);
  return `var(${fixed.get(name)})`;
}

/// What a custom property is now, for canvases.
export const valueOf = (property) => getComputedStyle(document.documentElement).getPropertyValue(property).trim();
export const onThemeChange = (listener) =>
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", listener);
