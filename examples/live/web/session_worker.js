// Runs the session in a thread of its own, so that the page stays responsive while a picture is computed.

const folder = new URL(self.crossOriginIsolated ? "threads/" : "./", location.href).href;
importScripts(`${folder}scanner.js`);

let live;

const text = (name, ...values) =>
    live.ccall(name, "string", values.map((value) => (typeof value === "string" ? "string" : "number")), values);

// Calls a function that returns the reason of its failure, and reports it.
function attempt(name, ...values) {
    const fault = text(name, ...values);
    if (fault) postMessage({ kind: "fault", fault });
    return !fault;
}

// Copies a mesh from its description.
function mesh(described) {
    if (!described) return undefined;
    const { positions, points, faces, triangles, ...rest } = JSON.parse(described);
    return {
        ...rest,
        positions: new Float32Array(live.HEAPU8.buffer, positions, 3 * points).slice(),
        faces: new Uint32Array(live.HEAPU8.buffer, faces, 3 * triangles).slice(),
    };
}

let needle = -1, applied = 0, body; // id of the last one that was sent, which changes with its mesh; events so far; number of the body

function sendAnatomy() {
    const parts = Array.from({ length: live._live_parts() }, (_, index) => mesh(text("live_part", index)));
    postMessage({ kind: "anatomy", parts: parts.filter((one) => one), probe: mesh(text("live_probe")), begins: live._live_begins() !== 0 });
    needle = -1;
}

function begun() {
    sendAnatomy();
    body = undefined;
}

function draw({ live: passes }) {
    const begin = performance.now(), drawn = attempt("live_frame", passes), milliseconds = performance.now() - begin;
    const state = { ...JSON.parse(text("live_state")), milliseconds, applied };
    if (body !== undefined && state.body > body) sendAnatomy(); // a case has been opened
    body = state.body;
    const message = { kind: "frame", drawn, state };
    const copy = (at, { width, height }) => live.HEAPU8.slice(at, at + 4 * width * height).buffer;
    if (drawn) Object.assign(message, { pixels: copy(live._live_pixels(), state), strip: copy(live._live_strip(), state.strip) });
    if (state.needle_id !== needle) {
        needle = state.needle_id;
        message.needle = mesh(text("live_needle"));
    }
    postMessage(message, drawn ? [message.pixels, message.strip] : []);
}

let opened = []; // files of the anatomy, which recordings name

function load({ files, unit, side, skin, repair, pennation, tissue, background }) {
    for (const { name, bytes } of files) live.FS.writeFile(name, new Uint8Array(bytes));
    const names = files.map(({ name }) => name), model = names.find((name) => /\.obj$/i.test(name));
    const { fault, notes } = JSON.parse(text("live_load", model, unit, side, skin, repair, pennation, tissue, background));
    const [kept, left] = fault ? [opened, names] : [names, opened];
    for (const name of left) if (!kept.includes(name)) live.FS.unlink(name);
    opened = kept;
    if (!fault) begun();
    if (fault || notes) postMessage({ kind: "fault", fault: fault || notes });
    postMessage({ kind: "loaded", name: fault ? undefined : model });
}

function recording({ name, text: lines }) {
    live.FS.writeFile(name, lines);
    postMessage({ kind: "recording", ...JSON.parse(text("live_recording", name)) });
    live.FS.unlink(name);
}

const handlers = {
    event({ line }) {
        ++applied;
        attempt("live_apply", line);
    },
    draw,
    load,
    recording,
    restart({ recorded }) {
        live._live_restart(recorded);
        begun();
    },
};

makeScanner({ locateFile: (name) => folder + name, mainScriptUrlOrBlob: `${folder}scanner.js` }).then((made) => {
    live = made;
    postMessage({
        kind: "ready",
        controls: JSON.parse(text("live_controls")),
        tissues: text("live_tissues").split(" "),
        instructions: text("live_instructions"),
        threads: self.crossOriginIsolated ? navigator.hardwareConcurrency : 1,
    });
    sendAnatomy();
    self.onmessage = ({ data }) => handlers[data.kind](data);
    postMessage({ kind: "started" });
}).catch((fault) => setTimeout(() => { throw fault; })); // the page hears of errors, not of rejections
