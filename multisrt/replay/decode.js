// The data of the page: inflated, and unpacked into arrays. Lengths become metres, times seconds.

const KNOWN_VERSION = 1;

async function readData() {
  const packed = JSON.parse(document.getElementById("data").textContent);
  if (typeof DecompressionStream !== "function") {
    throw new Error("This browser is too old for the replay: it has no DecompressionStream.");
  }
  const bytes = Uint8Array.from(atob(packed), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  const data = JSON.parse(await new Response(stream).text());
  if (data.version !== KNOWN_VERSION) {
    throw new Error(`The data of this page have version ${data.version}, not ${KNOWN_VERSION}.`);
  }
  return data;
}

// Numbers of which each is packed as the difference from the one before.
function running(differences, perUnit = 1) {
  const values = new Float64Array(differences.length);
  let sum = 0;
  for (let i = 0; i < differences.length; i++) values[i] = (sum += differences[i]) / perUnit;
  return values;
}

function whole(differences) {
  return Int32Array.from(running(differences));
}

// Positions of the first of each of some lists within all of them, and the end of the last.
function firsts(lengths) {
  const first = new Int32Array(lengths.length + 1);
  for (let i = 0; i < lengths.length; i++) first[i + 1] = first[i] + lengths[i];
  return first;
}

// Lines or outlines: points first[i] to first[i + 1] - 1 are those of number i.
function unpackPoints(packed) {
  return { first: firsts(packed.n), x: running(packed.x, 1000), y: running(packed.y, 1000) };
}

function unpackLists(packed) {
  const first = firsts(packed.n), all = whole(packed.of);
  return packed.n.map((_, i) => all.subarray(first[i], first[i + 1]));
}

// The index of the last of some sorted times that is not later; -1 if there is none.
function lastBy(times, time) {
  let low = -1, high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle - 1;
  }
  return low;
}

// Rows of a table by robot: the numbers of the rows and their times, which rise.
function byRobot(robots, times, count) {
  const rows = Array.from({ length: count }, () => []);
  robots.forEach((robot, row) => rows[robot].push(row));
  return rows.map((own) => ({ rows: own, t: own.map((row) => times[row]) }));
}
