import { Panel } from "./panel.js";
import { Picture } from "./picture.js";
import { Space } from "./space.js";

const id = (name) => document.getElementById(name);
const frame_time = 1000 / 30; // the session advances by this from picture to picture, ms

const worker = new Worker("session_worker.js");
const picture = new Picture(id("picture"));
let space, panel, state, beginning = [];
let waiting;        // takes the next frame
let playing = false; // a recorded session
let last = 0, shown = [], asked = true;

function send(line) {
    worker.postMessage({ kind: "events", lines: [line] });
    if (state?.frozen && !asked) ask();
}

function ask() {
    asked = true;
    worker.postMessage({ kind: "draw" });
}

function report(fault) {
    id("fault").firstElementChild.textContent = fault;
    id("fault").hidden = false;
}

function show_rate() {
    const now = performance.now();
    shown = [...shown.filter((time) => time > now - 1000), now];
    const rate = shown.length > 1 ? 1000 * (shown.length - 1) / (now - shown[0]) : 0;
    id("rate").textContent = state.frozen ? "" : `${rate.toFixed(0)} frames/s · ${(1e3 * state.seconds).toFixed(0)} ms`;
}

function legend_entry({ name, colour }) {
    const entry = document.createElement("span"), paint = document.createElement("i");
    paint.style.background = `rgb(${colour[0].map((part) => Math.round(255 * part)).join()})`;
    entry.append(paint, name);
    return entry;
}

// The worker draws the next picture while the page shows this one.
function ask_again() {
    if (playing || state.frozen) return;
    const now = performance.now();
    last = Math.max(now, last + frame_time);
    if (last > now) setTimeout(() => playing || ask(), last - now); // playback may have begun since
    else ask();
}

function show(message) {
    asked = false;
    state = message.state;
    ask_again();
    if (message.drawn) picture.show(state, message.pixels, message.strip);
    if (message.needle) space.show_needle(message.needle);
    space.show(state, picture.pixels);
    panel.update(state.values);
    id("inserted").textContent = `${(state.values.advance ?? 0).toFixed(1)} mm`;
    id("frozen").hidden = !state.frozen;
    id("freeze").textContent = state.frozen ? "Unfreeze" : "Freeze";
    id("freeze").setAttribute("aria-pressed", state.frozen);
    id("legend").replaceChildren(...state.legend.map(legend_entry));
    show_rate();
    id("loading").hidden = true;
    if (waiting) {
        const take = waiting;
        waiting = undefined;
        take(state);
    }
}

function next_frame() {
    return new Promise((take) => (waiting = take));
}

/** Plays a recorded session: lines of events, of which "frame", "frames N" and "frames N event" draw.
 *  @param seen  called after each picture, with its state and its canvas */
async function play(text, seen = () => {}) {
    playing = true;
    if (asked) await next_frame();
    worker.postMessage({ kind: "restart" });
    panel.reset();
    const apply = (line) => worker.postMessage({ kind: "events", lines: [line] });
    playback: for (const line of text.split(/\r?\n/)) {
        const frames = /^\s*frames?\b\s*(\d*)([^#]*)/.exec(line);
        if (!frames) {
            apply(line);
            continue;
        }
        for (let count = Number(frames[1] || 1); count > 0; --count) {
            if (frames[2].trim()) apply(frames[2]);
            const begin = performance.now(), done = next_frame();
            ask();
            await done;
            if (await seen(state, picture.pixels) === false) break playback;
            await new Promise((then) => setTimeout(then, Math.max(0, begin + frame_time - performance.now())));
        }
    }
    playing = false;
    ask();
}

function restart() {
    worker.postMessage({ kind: "restart" });
    for (const line of beginning) send(line);
    panel.reset();
    id("examination").textContent = "Nerve block, linear probe";
    if (!asked) ask();
}

const options = () => Object.fromEntries(new FormData(id("load").querySelector("form")));

// Asks for the unit of an OBJ file and loads it; plays a recorded session.
async function open(files) {
    const all = [...files], model = all.find(({ name }) => /\.obj$/i.test(name)), recording = all.find(({ name }) => /\.txt$/i.test(name));
    if (recording) return play(await recording.text());
    if (!model) return report(`${all[0].name}: open an OBJ file (with its MTL file), or a recorded session (TXT)`);
    id("file_name").textContent = model.name;
    id("load").returnValue = "";
    id("load").showModal();
    await new Promise((closed) => id("load").addEventListener("close", closed, { once: true }));
    if (id("load").returnValue !== "load") return;
    const { unit, side, tissue, background } = options();
    const bytes = await Promise.all(all.map(async (file) => ({ name: file.name, bytes: await file.arrayBuffer() })));
    id("fault").hidden = true;
    worker.postMessage({ kind: "load", files: bytes, unit: Number(unit), side: Number(side), tissue, background });
}

const handlers = {
    ready({ controls, tissues, instructions, threads }) {
        space = new Space(id("anatomy"), send);
        panel = new Panel(controls, send, { choices: id("choices"), tabs: id("tabs"), groups: id("groups") });
        for (const name of ["tissue", "background"])
            for (const tissue of tissues) id("load").querySelector(`[name=${name}]`).add(new Option(tissue.replaceAll("_", " "), tissue));
        id("load").querySelector("[name=tissue]").value = "muscle";
        id("load").querySelector("[name=background]").value = "gel";
        // One thread draws 128 lines of one elevation plane at 15 pictures per second or more.
        beginning = ["lines 128", `planes ${threads > 1 ? 3 : 1}`, "width 384"];
        choose("slide");
        Object.assign(window, { scanner: { send, play, seen: (name) => space.seen(name), state: () => state, pixels: picture.pixels, instructions, threads } });
    },
    started() {
        for (const line of beginning) send(line);
        ask();
    },
    anatomy: ({ parts }) => space.show_anatomy(parts),
    frame: show,
    fault: ({ fault }) => report(fault),
    loaded() {
        for (const line of beginning) send(line);
        if (id("fault").hidden) {
            id("examination").textContent = id("file_name").textContent;
            panel.reset();
        }
        if (!asked) ask();
    },
};
worker.onmessage = ({ data }) => handlers[data.kind](data);
worker.onerror = ({ message }) => {
    id("loading").hidden = true;
    report(`The scanner did not start: ${message || "the page must come from a web server, such as python3 -m http.server"}`);
};

function choose(tool) {
    space.tool = tool;
    for (const button of document.querySelectorAll("[data-tool]")) {
        button.setAttribute("role", "radio");
        button.setAttribute("aria-checked", button.dataset.tool === tool);
    }
}

for (const button of document.querySelectorAll("[data-tool]")) button.onclick = () => choose(button.dataset.tool);
const freeze = () => send(state.frozen ? "unfreeze" : "freeze");
id("freeze").onclick = freeze;
id("reset").onclick = restart;
id("fault").querySelector("button").onclick = () => (id("fault").hidden = true);
id("help").onclick = () => id("hint").showModal();
id("open").onclick = () => id("file").click();
id("file").onchange = ({ target }) => {
    if (target.files.length) open(target.files);
    target.value = "";
};
if (!localStorage.getItem("insonify-hint")) id("hint").showModal();
id("hint").addEventListener("close", () => localStorage.setItem("insonify-hint", "seen"));

addEventListener("dragover", (event) => {
    event.preventDefault();
    id("drop").hidden = false;
});
addEventListener("dragleave", (event) => {
    if (!event.relatedTarget) id("drop").hidden = true;
});
addEventListener("drop", (event) => {
    event.preventDefault();
    id("drop").hidden = true;
    if (event.dataTransfer.files.length) open(event.dataTransfer.files);
});

// Held keys and buttons act at 30 mm or degrees per second.
const held = new Map();
const moves = {
    ArrowLeft: "slide -1 0", ArrowRight: "slide 1 0", ArrowUp: "slide 0 -1", ArrowDown: "slide 0 1", s: "tilt -1", w: "tilt 1",
    a: "rock -1", d: "rock 1", q: "rotate -1", e: "rotate 1", PageUp: "advance -1", PageDown: "advance 1",
};
function hold(name, line) {
    if (held.has(name)) return;
    held.set(name, line);
    send(line.replace(/-?1\b/g, (one) => 0.5 * one));
    if (held.size === 1) repeat();
}
function repeat() {
    let before = performance.now();
    const timer = setInterval(() => {
        if (!held.size) return clearInterval(timer);
        const now = performance.now(), step = 0.02 * (now - before);
        before = now;
        for (const line of held.values()) send(line.replace(/-?1\b/g, (one) => (step * one).toFixed(3)));
    }, 33);
}
addEventListener("keydown", (event) => {
    if (event.target.closest("input, select, dialog") || event.ctrlKey || event.metaKey || !state) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (key === " " && !event.repeat && !event.target.closest("button")) freeze();
    else if (moves[key]) hold(key, moves[key]);
    else return;
    event.preventDefault();
});
addEventListener("keyup", ({ key }) => held.delete(key.length === 1 ? key.toLowerCase() : key));
addEventListener("blur", () => held.clear());
for (const [name, line] of [["advance", "advance 1"], ["withdraw", "advance -1"]]) {
    id(name).onpointerdown = () => hold(name, line);
    id(name).onpointerup = id(name).onpointerleave = id(name).onpointercancel = () => held.delete(name);
    id(name).onkeydown = ({ key }) => key === "Enter" && send(line);
}
