// Unpacks what the report's writer put into the page.

export async function unpacked(id) {
  const text = document.getElementById(id).textContent;
  const letters = atob(text), packed = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; ++i) packed[i] = letters.charCodeAt(i);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/// {version, written, machine, results, runs, timelines, replays, worst, worlds}
export const readData = async () => JSON.parse(new TextDecoder().decode(await unpacked("data")));

/// All rows of a bench, of every file, each with its file and machine.
export const rowsOf = (data, bench) =>
  data.results.flatMap((result) => result.rows.filter((row) => row.bench === bench)
    .map((row) => ({...row, file: result.file, machine: result.machine})));
