import { Panel } from "./panel.js";
import { Picture } from "./picture.js";
import { Space } from "./space.js";

const id = (name) => document.getElementById(name);

const worker = new Worker("session_worker.js");
const picture = new Picture(id("picture"));
let space, panel, state, beginning = [];
let events = 0;     // sent so far
let playback;       // the recorded session that plays
let last = 0, shown = [], asked = true;
const drawn = [], read = []; // take the next picture, and the next recording
let file, titles = []; // that is examined or played, if it is one; of the cases

function post(line) {
    worker.postMessage({ kind: "event", line });
    return ++events;
}

function send(line) {
    if (/^(case|patient) /.test(line)) file = undefined;
    const number = post(line);
    if (state?.frozen && !asked) ask();
    return number;
}

function ask() {
    asked = true;
    worker.postMessage({ kind: "draw", live: !playback });
}

// What the browser keeps between visits; it refuses where cookies are blocked.
function keep(act) {
    try {
        return act(localStorage);
    } catch {
        return undefined;
    }
}

function report(fault) {
    id("fault").firstElementChild.textContent = fault;
    id("fault").hidden = false;
}

function show_rate() {
    const now = performance.now();
    shown = [...shown.filter((time) => time > now - 1000), now];
    const rate = shown.length > 1 ? 1000 * (shown.length - 1) / (now - shown[0]) : 0;
    id("rate").textContent = state.frozen ? "" : `${rate.toFixed(0)} frames/s · ${state.milliseconds.toFixed(0)} ms`;
}

function legend_entry({ name, colour }) {
    const entry = document.createElement("span"), paint = document.createElement("i");
    paint.style.background = `rgb(${colour[0].map((part) => Math.round(255 * part)).join()})`;
    entry.append(paint, name);
    return entry;
}

// The worker draws the next picture while the page shows this one.
function ask_again() {
    if (playback || state.frozen) return;
    const now = performance.now();
    last = Math.max(now, last + 1000 / 30); // at most 30 a second
    if (last > now) setTimeout(() => playback || asked || ask(), last - now); // others may have asked since
    else ask();
}

function show(message) {
    asked = false;
    state = message.state;
    ask_again();
    if (message.drawn) picture.show(state, message.pixels, message.strip);
    if (message.needle) space.show_needle(message.needle);
    space.show(state, picture.pixels);
    panel.update(state.values, state.applied);
    id("examination").textContent = file ?? titles[state.values.case] ?? "";
    id("inserted").textContent = `${(state.values.advance ?? 0).toFixed(1)} mm`;
    id("frozen").hidden = !state.frozen;
    id("freeze").textContent = state.frozen ? "Unfreeze" : "Freeze";
    id("freeze").setAttribute("aria-pressed", state.frozen);
    id("legend").replaceChildren(...state.legend.map(legend_entry));
    show_rate();
    id("loading").hidden = true;
    document.querySelector("main").inert = false;
    for (const take of drawn.splice(0)) take();
}

const next_frame = () => new Promise((take) => drawn.push(take));

/** Plays a recorded session: a text of events. Another one, or a start from the beginning, ends it.
 *  @param seen  called after each picture; returns false to end */
async function play(text, seen = () => {}, name = "recording.txt") {
    worker.postMessage({ kind: "recording", name, text });
    const { steps, fault } = await new Promise((take) => read.push(take));
    if (fault) return report(fault);
    const mine = (playback = {}), goes_on = () => playback === mine;
    if (asked) await next_frame();
    if (!goes_on()) return;
    worker.postMessage({ kind: "restart", recorded: true });
    panel.reset();
    picture.calliper = undefined;
    file = name;
    for (const { frames, event } of steps) {
        if (!frames) post(event);
        for (let i = 0; i < frames; ++i) {
            if (event) post(event);
            const begin = performance.now(), shown = next_frame();
            ask();
            await shown;
            if (goes_on() && await seen() === false) playback = undefined;
            await new Promise((then) => setTimeout(then, begin + state.interval - performance.now()));
            if (!goes_on()) return;
        }
    }
    playback = undefined;
    if (!asked) ask();
}

// Ends playback and begins a session; `then` tells the worker which.
function begin(then) {
    playback = undefined;
    then();
    for (const line of beginning) post(line);
    panel.reset();
    picture.calliper = undefined;
    if (!asked) ask();
}

function restart() {
    begin(() => worker.postMessage({ kind: "restart" }));
    file = undefined;
}

const options = () => Object.fromEntries(new FormData(id("load").querySelector("form")));

// Asks for the unit of an OBJ file and loads it; plays a recorded session.
async function open(files) {
    const all = [...files];
    await ready;
    if (id("load").open) return;
    const model = all.find(({ name }) => /\.obj$/i.test(name)), recording = all.find(({ name }) => /\.txt$/i.test(name));
    id("fault").hidden = true;
    try {
        if (recording) return await play(await recording.text(), undefined, recording.name);
        if (!model) return report(`${all[0].name}: open an OBJ file (with its MTL file), or a recorded session (TXT)`);
        id("file_name").textContent = model.name;
        id("load").returnValue = "";
        id("load").showModal();
        await new Promise((closed) => id("load").addEventListener("close", closed, { once: true }));
        if (id("load").returnValue !== "load") return;
        const { unit, side, skin, repair, pennation, tissue, background } = options();
        const used = [model, ...all.filter(({ name }) => /\.mtl$/i.test(name))];
        const bytes = await Promise.all(used.map(async (file) => ({ name: file.name, bytes: await file.arrayBuffer() })));
        worker.postMessage({ kind: "load", files: bytes, unit: Number(unit), side: Number(side), skin: 1e-3 * Number(skin), repair: repair !== undefined, pennation: Number(pennation), tissue, background });
    } catch (fault) { // of the browser: a folder, or a file that is gone or may not be read
        report(`${(recording ?? model).name} cannot be read: ${fault.message}`);
    }
}

let set_ready;
const ready = new Promise((then) => (set_ready = then));
const handlers = {
    ready({ controls, tissues, instructions, threads }) {
        space = new Space(id("anatomy"), send, report);
        // One thread draws 128 lines of one elevation plane at 15 pictures per second or more.
        const first = { lines: 128, planes: threads > 1 ? 3 : 1, width: 384 };
        titles = controls.find(({ event }) => event === "case").choices.map(({ name }) => name);
        for (const one of controls) one.value = first[one.event] ?? one.value;
        beginning = Object.entries(first).map(([event, value]) => `${event} ${value}`);
        panel = new Panel(controls, send, { choices: id("choices"), tabs: id("tabs"), groups: id("groups") });
        for (const name of ["tissue", "background"])
            for (const tissue of tissues) id("load").querySelector(`[name=${name}]`).add(new Option(tissue.replaceAll("_", " "), tissue));
        id("load").querySelector("[name=tissue]").value = "muscle";
        id("load").querySelector("[name=background]").value = "gel";
        choose("slide");
        Object.assign(window, { scanner: { send, play, seen: (name) => space.seen(name), state: () => state, pixels: picture.pixels, picture, space, instructions, threads } });
    },
    started() {
        for (const line of beginning) post(line);
        ask();
        set_ready();
    },
    anatomy({ parts, probe, begins }) {
        space.show_anatomy(parts, begins);
        space.show_probe(probe);
    },
    frame: show,
    fault: ({ fault }) => report(fault),
    recording: (answer) => read.shift()(answer),
    loaded({ name }) {
        if (!name) return;
        begin(() => {});
        file = name;
    },
};
worker.onmessage = ({ data }) => handlers[data.kind](data);
worker.onerror = ({ message }) => {
    id("loading").hidden = true;
    report(state ? `The scanner has stopped: ${message}; load the page again`
        : `The scanner did not start: ${message || "the page must come from a web server, such as python3 -m http.server"}`);
};

function choose(tool) {
    space.tool = tool;
    for (const button of document.querySelectorAll("[data-tool]")) button.setAttribute("aria-pressed", button.dataset.tool === tool);
}

for (const button of document.querySelectorAll("[data-tool]")) button.onclick = () => choose(button.dataset.tool);
const freeze = () => send(state.frozen ? "unfreeze" : "freeze");
id("freeze").onclick = freeze;
id("reset").onclick = restart;
id("entry").onclick = () => id("entry").setAttribute("aria-pressed", (space.moves_entry = !space.moves_entry));
function cut() {
    id("cut").setAttribute("aria-pressed", (space.cuts = !space.cuts));
    space.draw_soon();
}
id("cut").onclick = cut;
id("fault").querySelector("button").onclick = () => { id("fault").hidden = true; };
id("help").onclick = () => id("hint").showModal();
id("open").onclick = () => id("file").click();
id("file").onchange = ({ target }) => {
    if (target.files.length) open(target.files);
    target.value = "";
};
if (!keep((store) => store.getItem("insonify-hint"))) id("hint").showModal();
id("hint").addEventListener("close", () => keep((store) => store.setItem("insonify-hint", "seen")));

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

// Held keys and buttons: an event, and what is added to its numbers in a second.
const moves = {
    ArrowLeft: ["slide", -30, 0], ArrowRight: ["slide", 30, 0], ArrowUp: ["slide", 0, -30], ArrowDown: ["slide", 0, 30],
    s: ["tilt", -30], w: ["tilt", 30], a: ["rock", -30], d: ["rock", 30], q: ["rotate", -30], e: ["rotate", 30],
    r: ["press", -6], f: ["press", 6], PageUp: ["advance", -15], PageDown: ["advance", 15],
};
const held = new Map();
const move = ([name, ...rates], seconds) => send(`${name} ${rates.map((rate) => (rate * seconds).toFixed(3)).join(" ")}`);
const tap = (one) => move(one, 1 / 60);
function hold(name, one) {
    if (held.has(name)) return;
    held.set(name, one);
    tap(one);
    if (held.size === 1) repeat();
}
function repeat() {
    let before = performance.now();
    const timer = setInterval(() => {
        if (!held.size) return clearInterval(timer);
        const now = performance.now();
        for (const one of held.values()) move(one, 1e-3 * (now - before));
        before = now;
    }, 33);
}
const key_of = ({ key }) => (key.length === 1 ? key.toLowerCase() : key);
addEventListener("keydown", (event) => {
    if (event.target.closest("input, select, dialog") || event.ctrlKey || event.metaKey || event.altKey || !state) return;
    const key = key_of(event);
    if (event.target === space.canvas && space.steer(key, event.shiftKey)) return event.preventDefault();
    if (event.target === picture.canvas && picture.steer(key, event.shiftKey)) return event.preventDefault();
    if (key === " " && event.target.closest("button, summary")) return; // it presses that
    if (key === " ") event.repeat || freeze();
    else if (key === "c") event.repeat || cut();
    else if (moves[key]) hold(key, moves[key]);
    else return;
    event.preventDefault();
});
addEventListener("keyup", (event) => held.delete(key_of(event)));
addEventListener("blur", () => held.clear());
for (const [name, one] of [["advance", moves.PageDown], ["withdraw", moves.PageUp]]) {
    id(name).addEventListener("pointerdown", () => hold(name, one));
    for (const end of ["pointerup", "pointerleave", "pointercancel"]) id(name).addEventListener(end, () => held.delete(name));
    id(name).addEventListener("click", ({ detail }) => detail || tap(one)); // by a key, or by a program that speaks
}
