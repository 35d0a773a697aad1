// Tests the page in headless Chromium: node test.mjs SITE [--replay PROGRAM FILE] [--rate FRAMES_PER_SECOND] [--screenshots FOLDER]
//
// --replay compares the pictures of a recorded session with those of live_replay; --rate fails where the page is slower.
import { spawnSync } from "node:child_process";
import fs from "node:fs";
import http from "node:http";
import { createRequire } from "node:module";
import os from "node:os";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";

const puppeteer = createRequire(path.join(process.cwd(), "test.mjs"))("puppeteer-core"); // of the build tree
const [site, ...options] = process.argv.slice(2);
const option = (name, index = 1) => (options.includes(name) ? options[options.indexOf(name) + index] : undefined);
const scratch = fs.mkdtempSync(path.join(os.tmpdir(), "insonify-web-"));

let failed = 0;
function check(title, holds, measured) {
    console.log(`${holds ? "ok  " : "FAIL"} ${title}: ${measured}`);
    if (!holds) ++failed;
}

const types = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm", ".png": "image/png" };
/** @param session  waits before the session is sent; false: it is missing */
function serve(folder, headers, session = async () => true) {
    const server = http.createServer(async (request, response) => {
        const name = decodeURI(request.url.split("?")[0]), file = path.join(folder, name.endsWith("/") ? `${name}index.html` : name);
        if (!fs.existsSync(file) || (name.endsWith(".wasm") && !await session())) return response.writeHead(404).end();
        response.writeHead(200, { "content-type": types[path.extname(file)] ?? "text/plain", ...headers }).end(fs.readFileSync(file));
    });
    return new Promise((ready) => server.listen(0, "127.0.0.1", () => ready({ server, url: `http://127.0.0.1:${server.address().port}/` })));
}

const pause = (milliseconds) => new Promise((then) => setTimeout(then, milliseconds));
const errors = [];
const running = (page) => page.waitForFunction(() => window.scanner?.state()?.frame > 2, { timeout: 120_000 });
async function visit(browser, url, viewport) {
    const page = await browser.newPage();
    page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
    page.on("pageerror", (error) => errors.push(String(error?.message ?? error)));
    await page.evaluateOnNewDocument(() => { // what a user has operated, with its values
        window.operated = new Map();
        const note = ({ target, isTrusted }) => isTrusted && target instanceof Element &&
            operated.set(target, (operated.get(target) ?? new Set()).add(target.value ?? ""));
        for (const type of ["click", "input", "change", "toggle", "pointerdown", "keydown"]) addEventListener(type, note, true);
    });
    await page.setViewport(viewport);
    await page.goto(url);
    return page;
}
async function open(browser, url, viewport) {
    const page = await visit(browser, url, viewport);
    await running(page);
    return page;
}
const fault = (page) => page.$eval("#fault", (box) => (box.hidden ? "" : box.firstElementChild.textContent));
async function wait_for_fault(page) {
    await page.waitForSelector("#fault:not([hidden])");
    const sentence = await fault(page);
    await page.click("#fault button");
    return sentence;
}

const state = (page) => page.evaluate(() => scanner.state());
async function frames(page, count = 3) {
    const from = (await state(page)).frame;
    await page.waitForFunction((until) => scanner.state().frame >= until, { timeout: 60_000 }, from + count);
}
// Mean gray level, fraction of pixels that are not black, and the gray levels.
async function look(page) {
    const bytes = await page.evaluate(() => {
        const { width, height } = scanner.pixels, pixels = scanner.pixels.getContext("2d").getImageData(0, 0, width, height).data;
        return btoa(Array.from({ length: width * height }, (_, i) => String.fromCharCode(pixels[4 * i])).join(""));
    });
    const grey = Buffer.from(bytes, "base64"), mean = grey.reduce((sum, one) => sum + one, 0) / grey.length;
    return { grey, mean, bright: grey.filter((one) => one > 20).length / grey.length };
}
// Fraction of pixels that differ by more than 2 of 255.
const difference = (a, b) => a.length !== b.length ? 1 : a.reduce((sum, one, i) => sum + (Math.abs(one - b[i]) > 2), 0) / a.length;
const millimetres = ({ probe }) => [1e3 * probe[12], 1e3 * probe[13]];

async function drag(page, name, x, y) {
    const from = await page.evaluate((part) => scanner.seen(part), name);
    await page.mouse.move(from.x, from.y);
    await page.mouse.down();
    for (let i = 1; i <= 5; ++i) await page.mouse.move(from.x + (x * i) / 5, from.y + (y * i) / 5);
    await page.mouse.up();
    await frames(page, 4);
}

async function test_controls(page) {
    let before = await look(page);
    check("the picture is not black", before.bright > 0.2, `${(100 * before.bright).toFixed(0)} % of pixels above 20 of 255; expected > 20 %`);
    const { instructions, threads } = await page.evaluate(() => ({ instructions: scanner.instructions, threads: scanner.threads }));
    check("the library uses SIMD", instructions.includes("wasm128"), `${instructions}, ${threads} thread(s)`);

    await page.focus('input[name="gain"]');
    for (let i = 0; i < 10; ++i) await page.keyboard.press("ArrowRight");
    await page.waitForFunction(() => scanner.state().values.gain === 10, { timeout: 60_000 });
    await frames(page);
    let after = await look(page);
    check("the gain slider brightens the picture", after.mean > before.mean + 10, `mean level ${before.mean.toFixed(1)} -> ${after.mean.toFixed(1)} at +10 dB`);

    before = await look(page);
    let from = millimetres(await state(page));
    await drag(page, "probe", 60, 20);
    let to = millimetres(await state(page));
    after = await look(page);
    const moved = Math.hypot(to[0] - from[0], to[1] - from[1]);
    check("dragging the probe slides it", moved > 3 && moved < 40, `${moved.toFixed(1)} mm for 63 pixels`);
    check("... and the picture follows", difference(before.grey, after.grey) > 0.1, `${(100 * difference(before.grey, after.grey)).toFixed(0)} % of pixels differ`);
    await page.keyboard.down("Shift");
    await drag(page, "probe", 0, 40);
    await page.keyboard.up("Shift");
    const tilt = (180 / Math.PI) * Math.asin((await state(page)).probe[9]);
    check("dragging with Shift tilts it", Math.abs(Math.abs(tilt) - 10) < 0.5, `${tilt.toFixed(1)} degrees for 40 pixels; expected 10`);

    const inserted = (await state(page)).values.advance;
    await drag(page, "needle", 40, 20);
    const now = (await state(page)).values.advance;
    check("dragging the needle advances it", now > inserted + 2, `${inserted.toFixed(1)} -> ${now.toFixed(1)} mm`);

    from = (await state(page)).probe;
    const corner = await page.$eval("#anatomy", (canvas) => canvas.getBoundingClientRect().toJSON());
    await page.mouse.move(corner.left + 20, corner.top + 20);
    await page.mouse.down();
    await page.mouse.move(corner.left + 70, corner.top + 40);
    await page.mouse.up();
    await frames(page);
    check("dragging beside them moves neither", String(from) === String((await state(page)).probe), "pose unchanged");

    await page.click("#freeze");
    await page.waitForFunction(() => scanner.state().frozen);
    const frozen = await state(page);
    await pause(400);
    check("frozen, nothing is drawn", (await state(page)).frame === frozen.frame, `frame ${frozen.frame} stays`);
    await page.click("#freeze");
    await page.waitForFunction(() => !scanner.state().frozen);
    await page.click("#reset");
    await frames(page);
}

function file(name, text) {
    const at = path.join(scratch, name);
    fs.writeFileSync(at, text);
    return at;
}
/** A box as an object of an OBJ file. @param before  boxes before it in the file  @param faces  so many of the six */
function box_object(name, [x, y, z], [from_x, from_y, from_z] = [0, 0, 0], before = 0, faces = 6, tissue = undefined) {
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((i) => `v ${from_x + (i & 1 ? x : 0)} ${from_y + (i & 2 ? y : 0)} ${from_z + (i & 4 ? z : 0)}`);
    const sides = [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]].slice(0, faces);
    return `o ${name}\n${tissue ? `usemtl ${tissue}\n` : ""}${corners.join("\n")}\n${sides.map((side) => `f ${side.map((i) => i + 8 * before).join(" ")}`).join("\n")}\n`;
}
async function choose_file(page, ...names) {
    await (await page.$("#file")).uploadFile(...names);
    await page.waitForSelector("#load[open]");
}
async function load_file(page, ...names) {
    await choose_file(page, ...names);
    await page.click('#load button[value="load"]');
    await page.waitForFunction(() => !document.getElementById("load").open);
}
async function load_anatomy(page, name, text) {
    await load_file(page, file(name, text));
    await page.waitForFunction((shown) => document.getElementById("examination").textContent === shown, { timeout: 60_000 }, name);
    await frames(page);
}
async function reset(page) {
    await page.click("#reset");
    await frames(page);
}

async function test_files(page) {
    await load_file(page, file("broken.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n"));
    const sentence = await wait_for_fault(page);
    check("a broken OBJ file gives a sentence", /broken\.obj:4: /.test(sentence), sentence);
    await frames(page);
    const kept = await look(page);
    check("... and the session goes on", kept.bright > 0.2, `${(100 * kept.bright).toFixed(0)} % of pixels above 20`);

    await load_file(page, file("lid.obj", box_object("lid", [40, 40, 30], [0, 0, 0], 0, 5)));
    const open_mesh = await wait_for_fault(page);
    check("an open mesh is refused in words", /lid\.obj: object .*open along/.test(open_mesh), open_mesh);
    check("... which says what closes it", /'Close open surfaces' may close it/.test(open_mesh), open_mesh);
    await choose_file(page, file("lid.obj", box_object("lid", [40, 40, 30], [0, 0, 0], 0, 5)));
    await page.click('#load [name="repair"]');
    await page.click('#load button[value="load"]');
    const closed = await wait_for_fault(page);
    check("... and closes it when asked, and says so", /lid\.obj:.*Closed 1 hole/.test(closed) && !/open along/.test(closed), closed);
    await page.evaluate(() => (document.querySelector('#load [name="repair"]').checked = false));
    await load_file(page, file("tiny.obj", box_object("tiny", [1, 1, 1])));
    const unit = await wait_for_fault(page);
    check("a wrong unit is refused in words", /1 mm large/.test(unit), unit);
    const gone = file("gone.obj", box_object("gone", [40, 40, 30]));
    await choose_file(page, gone);
    fs.rmSync(gone);
    await page.click('#load button[value="load"]');
    const unread = await wait_for_fault(page);
    check("a file that cannot be read gives a sentence", /gone\.obj cannot be read: /.test(unread), unread);
    await (await page.$("#file")).uploadFile(file("recorded.txt", "width 200\ngain loud\nframe\n"));
    const line = await wait_for_fault(page);
    check("a recording that cannot be read names the line", /recorded\.txt:2: gain/.test(line), line);

    await load_anatomy(page, "box.obj", box_object("box", [40, 40, 30]));
    const seen = await look(page), width = seen.grey.length / (await state(page)).height;
    const depth = 1e3 * (await state(page)).pitch, row = Math.round(29.6 / depth);
    const below = seen.grey.subarray(width * Math.round(35 / depth)).reduce((sum, one) => sum + one, 0) / (seen.grey.length - width * Math.round(35 / depth));
    check("an OBJ file is scanned", seen.mean > 20 && below < 0.5 * seen.mean, `mean level ${seen.mean.toFixed(1)}, below the box ${below.toFixed(1)}; its far side is at row ${row}`);
    await reset(page);

    await (await page.$("#file")).uploadFile(file("long.txt", "width 200\nlines 16\nframes 1000000 slide 0.1 0\n"));
    await page.waitForFunction(() => document.getElementById("examination").textContent === "long.txt" && scanner.state().values.lines === 16, { timeout: 60_000 });
    await reset(page);
    await page.waitForFunction(() => scanner.state().values.lines === 128, { timeout: 60_000 });
    const before = millimetres(await state(page))[0];
    await frames(page, 5);
    const after = millimetres(await state(page))[0];
    check("Reset ends a recorded session", before === after && await page.$eval("#examination", ({ textContent }) => textContent.startsWith("Nerve")), `the probe stays at ${after.toFixed(1)} mm`);
}

const limb = fileURLToPath(new URL("../tests/limb.obj", import.meta.url));

// A session that was recorded on an anatomy of its own, and what is told of an OBJ file.
async function test_recordings(page) {
    const recorded = path.join(path.dirname(limb), "recorded.txt"), text = fs.readFileSync(limb, "utf8");
    const examination = () => page.$eval("#examination", ({ textContent }) => textContent);
    const play = async () => await (await page.$("#file")).uploadFile(recorded);
    await play();
    const missing = await wait_for_fault(page);
    check("a recording on an anatomy that is not open says which one", /^limb\.obj, on which the session was recorded, cannot be opened; open the file of that time first$/.test(missing) && /^Nerve/.test(await examination()), missing);
    await load_anatomy(page, "limb.obj", text.replace("v 45.000 ", "v 45.001 "));
    await play();
    const changed = await wait_for_fault(page);
    check("... and on one that has changed since, that it has", /^limb\.obj has changed since the session was recorded; open the file of that time first$/.test(changed) && await examination() === "limb.obj", changed);
    await load_anatomy(page, "limb.obj", text);
    await play();
    await page.waitForFunction(() => scanner.state().measured, { timeout: 60_000 });
    const { measured, frozen, values } = await state(page), parts = await page.evaluate(() => scanner.space.anatomy.children.length);
    check("... and is played on the right one", await examination() === "recorded.txt" && frozen && values.lines === 48 && parts === (text.match(/^o /gm)).length + 1 && !await fault(page), `${parts} objects, the skin that was added among them`);
    const greens = () => page.evaluate((points) => { // of the ends of a measurement
        const { canvas } = scanner.picture, { left, top, scale } = scanner.picture.layout(), ratio = canvas.width / canvas.clientWidth;
        return points.map(({ x, y }) => [...canvas.getContext("2d").getImageData(ratio * (left + x * scale), ratio * (top + y * scale), 1, 1).data]);
    }, measured.points);
    const ends = await greens();
    // 70 and 30 pixels of 0.19 mm: 38 mm are 200 pixels
    check("what it has measured is drawn", ends.every(([red, green, blue]) => green > 180 && green > red + 60 && blue > red) && measured.text === `${(0.19 * Math.hypot(70, 30)).toFixed(1)} mm`, `${measured.text}; ends of ${ends.map((one) => one.slice(0, 3).join(" ")).join(" and ")}`);
    await screenshot(page, "measured.png");
    await page.focus("#picture");
    await page.keyboard.press("ArrowRight");
    const own = await greens();
    await page.keyboard.press("Escape");
    check("... and makes way for a calliper", own.every(([red, green]) => green < red + 60) && String(await greens()) === String(ends), "and returns after it");
    await reset(page);
    check("... until Reset", !(await state(page)).measured, "gone");

    await load_anatomy(page, "twins.obj", box_object("rib", [40, 40, 10], [0, 0, 0], 0, 6, "bone") + box_object("rib", [40, 40, 10], [0, 0, 15], 1, 6, "bone"));
    const twins = await wait_for_fault(page);
    check("objects of one name are told", /twins\.obj:\d+: there are several objects of the name 'rib'; this one is called 'rib\.2'/.test(twins), twins);
    await reset(page);
}

// Another case by its list: a body with a convex probe, its picture and its 3-D view; another patient; and the needle's entry.
async function test_cases(page) {
    const linear = await state(page), seen = (selector) => page.$eval(selector, ({ textContent }) => textContent);
    const titles = await page.$$eval("select[name=case] option", (all) => all.map(({ textContent }) => textContent));
    const number = titles.indexOf("Abdomen: gallbladder"), open = async (value) => {
        await page.select("select[name=case]", String(value));
        await page.waitForFunction((wanted) => scanner.state().values.case === wanted, { timeout: 120_000 }, value);
        await frames(page);
    };
    await open(number);
    const sector = await state(page), { grey, bright } = await look(page), at = (x, y) => grey[Math.floor(y * sector.height) * sector.width + Math.floor(x * sector.width)];
    check("a case of the list is a sector", sector.height < 0.85 * sector.width && linear.height > linear.width && await seen("#examination") === titles[number], `${sector.width} x ${sector.height} pixels, before ${linear.width} x ${linear.height}: ${await seen("#examination")}`);
    check("... which is black beside its lines, and full of echoes", at(0.01, 0.01) === 0 && at(0.99, 0.01) === 0 && bright > 0.35, `${(100 * bright).toFixed(0)} % of pixels above 20`);
    const shown = await page.evaluate(() => { // on the page: how bright the middle of the canvas is, and how wide the probe
        const { canvas } = scanner.picture, { left, top, scale } = scanner.picture.layout(), ratio = canvas.width / canvas.clientWidth, { width, height } = scanner.state();
        const { data } = canvas.getContext("2d").getImageData(ratio * (left + 0.4 * width * scale), ratio * (top + 0.4 * height * scale), 40, 40);
        return { level: data.reduce((sum, one, i) => sum + (i % 4 === 0 ? one : 0), 0) / 1600, room: width * scale / (canvas.clientWidth - 74), head: 2e3 * scanner.space.head.geometry.boundingBox.max.x, parts: scanner.space.anatomy.children.length };
    });
    check("... on the page, with its probe and its anatomy", shown.level > 20 && shown.room > 0.98 && shown.head > 60 && shown.parts > 30, `mean level ${shown.level.toFixed(0)}, ${(100 * shown.room).toFixed(0)} % of the width; probe ${shown.head.toFixed(0)} mm, ${shown.parts} objects`);
    await screenshot(page, "case.png");
    const usual = grey;
    await page.focus('input[name="patient"]');
    await page.keyboard.press("ArrowUp");
    await page.waitForFunction(() => scanner.state().values.patient === 1, { timeout: 120_000 });
    await frames(page);
    const other = difference(usual, (await look(page)).grey);
    check("another patient has another body", other > 0.2, `${(100 * other).toFixed(0)} % of pixels differ`);
    await open(0);
    const before = await state(page);
    await page.click("#entry");
    await drag(page, "needle", 0, 25);
    await page.click("#entry");
    const after = await state(page), moved = 1e3 * Math.hypot(after.entry[0][0] - before.entry[0][0], after.entry[0][1] - before.entry[0][1]);
    check("the needle enters elsewhere", moved > 3 && moved < 60 && after.values.advance === before.values.advance, `${moved.toFixed(1)} mm for 25 pixels`);
    await reset(page);
    check("Reset opens the first case", await seen("#examination") === titles[0] && (await state(page)).values.patient === 0, titles[0]);
}

// The 3-D view as RGB, and where points of the world are on it.
const view = (page, points) => page.evaluate((world) => {
    const { space } = scanner, { canvas } = space, { width, height } = canvas;
    space.place_camera();
    space.renderer.render(space.scene, space.camera);
    const pen = new OffscreenCanvas(width, height).getContext("2d");
    pen.drawImage(canvas, 0, 0);
    const { data } = pen.getImageData(0, 0, width, height), ratio = width / canvas.clientWidth;
    return world.map((point) => {
        const at = space.on_canvas(space.view.target.clone().fromArray(point)).multiplyScalar(ratio);
        const [x, y] = [Math.round(width / 2 + at.x), Math.round(height / 2 + at.y)], pixels = [];
        for (let i = -1; i <= 1; ++i) for (let k = -1; k <= 1; ++k) pixels.push([...data.slice(4 * ((y + i) * width + x + k), 4 * ((y + i) * width + x + k) + 3)]);
        return { x: x / width, y: y / height, pixels };
    });
}, points);
const between = (a, b, share) => a.map((one, i) => one + share * (b[i] - one));

async function test_space(page) {
    await page.evaluate(() => scanner.send("gain -40"));
    await frames(page);
    const { corners } = await state(page), shares = Array.from({ length: 40 }, (_, i) => (i + 0.5) / 40);
    const lines = async (a, b) => (await view(page, shares.map((share) => between(a, b, share))))
        .filter(({ pixels }) => pixels.some(([red, green, blue]) => blue > 110 && green > 90 && blue > red + 30)).length;
    const edge = await lines(corners[1], corners[2]), across = await lines(corners[0], corners[2]) + await lines(corners[1], corners[3]);
    check("the slice is outlined, and no line crosses it", edge > 10 && across < edge / 2, `on the edge ${edge} of 40 points are blue, on the diagonals ${across} of 80`);
    await reset(page);

    const parts = () => page.evaluate(() => scanner.space.anatomy.children.map(({ material }) => Number(material.opacity.toFixed(2))));
    const phantom = await parts();
    const far = [1000, 1000, 1000], wide = [300, 200, 120], inner = far.map((one, i) => one + 0.4 * wide[i]);
    await load_anatomy(page, "wide.obj", box_object("liver", wide, far));
    const alone = await parts(), [{ pixels }] = await view(page, [[0, 0.1, 0.06]]);
    const level = Math.max(...pixels.flat());
    check("an anatomy of 300 mm is opaque", alone.join() === "1" && level > 100, `opacity ${alone}; level ${level} of 255 on its side, the ground 39`);
    const eight = [0, 1, 2, 3, 4, 5, 6, 7].map((i) => [(i & 1 ? 0.15 : -0.15), (i & 2 ? 0.1 : -0.1), (i & 4 ? 0.12 : 0)]);
    const seen = await view(page, eight), inside = seen.filter(({ x, y }) => x > 0 && x < 1 && y > 0 && y < 1).length;
    const spread = Math.max(...seen.map(({ x }) => x)) - Math.min(...seen.map(({ x }) => x));
    check("... and is in view, 1 m from the origin of its file", inside === 8 && spread > 0.3, `${inside} of 8 corners, ${(100 * spread).toFixed(0)} % of the width`);
    const nested_body = box_object("body", wide, far, 0, 6, "muscle") + box_object("organ", [60, 40, 24], inner, 1, 6, "liver");
    await load_anatomy(page, "nested.obj", nested_body);
    check("what encloses others gets skin", (await parts()).length === 3, `opacities ${await parts()}`);
    const thickness = (text) => page.$eval('#load [name="skin"]', (one, value) => (one.value = value), text);
    await thickness("0");
    await load_anatomy(page, "nested.obj", nested_body);
    await thickness("1.5");
    const nested = await parts();
    check("what encloses others is transparent", nested.length === 2 && nested[0] < 0.5 && nested[0] > 0.2 && nested[1] === 1 && phantom.filter((one) => one < 1).length === 5,
        `opacities ${nested}; of the phantom ${phantom.filter((one) => one < 1)}, and 1 of ${phantom.filter((one) => one === 1).length} others`);
    await reset(page);
}

// Milliseconds that the page shows, beside those that its worker was busy with pictures.
async function test_milliseconds(page) {
    await page.workers()[0].evaluate(() => {
        const inner = self.onmessage;
        self.busy = [];
        self.onmessage = (event) => {
            const begin = performance.now();
            inner(event);
            if (event.data.kind === "draw") self.busy.push(performance.now() - begin);
        };
    });
    for (const [number, mode] of ["B", "M", "Colour", "Power", "Pulsed"].entries()) {
        await page.evaluate((line) => scanner.send(line), `mode ${number}`);
        await page.waitForFunction((value) => scanner.state().values.mode === value, { timeout: 60_000 }, number);
        const shares = [];
        for (let i = 0; i < 9; ++i) {
            const before = await page.workers()[0].evaluate(() => (self.busy = []).length);
            await frames(page, 1);
            const { milliseconds } = await state(page), busy = await page.workers()[0].evaluate(() => self.busy);
            if (busy.length > before) shares.push(Math.max(...busy.map((one) => Math.min(one, milliseconds) / Math.max(one, milliseconds))));
        }
        const median = shares.sort((a, b) => a - b)[shares.length >> 1];
        check(`the milliseconds of ${mode} are the picture's`, median > 0.8, `${(100 * median).toFixed(0)} % of the time that the worker is busy; expected > 80 %`);
    }
    await reset(page);
}

async function test_rate(browser, page) {
    const processes = await (await browser.target().createCDPSession());
    const cpu = async () => (await processes.send("SystemInfo.getProcessInfo")).processInfo.reduce((sum, one) => sum + one.cpuTime, 0);
    await frames(page, 10);
    const begin = performance.now(), from = (await state(page)).frame, busy = await cpu();
    await pause(4000);
    const { frame, values, milliseconds } = await state(page), drawn = frame - from;
    const rate = (1000 * drawn) / (performance.now() - begin), least = Number(option("--rate") ?? 0);
    check("frames per second", rate >= least, `${rate.toFixed(1)} at ${values.lines} lines, ${values.planes} plane(s), at most 30; expected >= ${least}; ` +
        `session ${milliseconds.toFixed(0)} ms, browser ${((1000 * (await cpu() - busy)) / drawn).toFixed(0)} ms of CPU a frame; load ${os.loadavg()[0].toFixed(1)} on ${os.cpus().length} cores`);
}

// Plays a recorded session; returns its pictures.
async function replay(page, text) {
    const pictures = [];
    await page.exposeFunction("picture_seen", async () => { pictures.push((await look(page)).grey); });
    await page.evaluate((events) => scanner.play(events, () => window.picture_seen()), text);
    return pictures;
}

async function test_replay(page, isolated) {
    const [program, recording] = [option("--replay", 1), option("--replay", 2)];
    const events = fs.readFileSync(recording, "utf8"), pictures = await replay(page, events);
    const desktop = spawnSync(program, [recording, "--threads", "1", "--every", "1", "--pictures", path.join(scratch, "desktop")]);
    const count = fs.readdirSync(scratch).filter((name) => name.startsWith("desktop")).length;
    check("the desktop replays", desktop.status === 0 && count > 0, `exit status ${desktop.status}, ${count} pictures`);
    const { server, url } = await serve(scratch, { "access-control-allow-origin": "*" });
    let worst = 0;
    for (const [i, mine] of pictures.entries()) {
        const theirs = await page.evaluate(async (address) => {
            const picture = await createImageBitmap(await (await fetch(address)).blob());
            const canvas = new OffscreenCanvas(picture.width, picture.height), pen = canvas.getContext("2d");
            pen.drawImage(picture, 0, 0);
            const pixels = pen.getImageData(0, 0, picture.width, picture.height).data;
            return btoa(Array.from({ length: pixels.length / 4 }, (_, k) => String.fromCharCode(pixels[4 * k])).join(""));
        }, `${url}desktop${i + 1}.png`);
        worst = Math.max(worst, difference(mine, Buffer.from(theirs, "base64")));
    }
    server.close();
    check("a recorded session gives the desktop's pictures", pictures.length === count && worst <= 1e-3,
        `${pictures.length} pictures; at most ${(1e6 * worst).toFixed(0)} of 1,000,000 pixels differ by more than 2 of 255; expected <= 1,000`);
    const threaded = await replay(isolated, events);
    const different = threaded.reduce((sum, one, i) => sum + !one.equals(pictures[i]), 0);
    check("threads give the same pictures", different === 0 && threaded.length === count, `${different} of ${threaded.length} differ`);
}

async function test_touch(page) {
    await page.click("#hint button");
    const handle = await page.evaluate(() => scanner.seen("probe")), from = millimetres(await state(page));
    await page.touchscreen.touchStart(handle.x, handle.y);
    for (let i = 1; i <= 4; ++i) await page.touchscreen.touchMove(handle.x + 10 * i, handle.y);
    await page.touchscreen.touchEnd();
    await frames(page, 4);
    const to = millimetres(await state(page));
    check("a finger slides the probe", to[0] > from[0] + 2, `${from[0].toFixed(1)} -> ${to[0].toFixed(1)} mm for 40 pixels`);
    const { wide, inner } = await page.evaluate(() => ({ wide: document.documentElement.scrollWidth, inner: innerWidth }));
    check("the page fits the phone", wide <= inner, `${wide} of ${inner} pixels wide`);
}

const controls = "button, input, select, summary, canvas[tabindex]";

// By keys alone: each control that is seen has its turn, and keys do what they do on other pages.
async function test_keyboard(page) {
    await page.evaluate(() => {
        document.activeElement.blur();
        document.querySelectorAll("details").forEach((group) => (group.open = true));
    });
    const total = await page.$$eval(controls, (all) => all.filter((one) => one.checkVisibility()).length), reached = [];
    for (const shift of [false, true]) {
        if (shift) await page.keyboard.down("Shift");
        for (let i = 0; i < total + 2; ++i) {
            await page.keyboard.press("Tab");
            reached.push(await page.evaluate((selector) => [...document.querySelectorAll(selector)].indexOf(document.activeElement), controls));
        }
        if (shift) await page.keyboard.up("Shift");
        const count = new Set(reached.splice(0).filter((i) => i >= 0)).size;
        check(`Tab${shift ? " with Shift" : ""} reaches every control`, count === total, `${count} of ${total}`);
    }
    const inserted = async () => (await state(page)).values.advance;
    const wait = (text) => page.waitForFunction(text, { timeout: 60_000 });
    await page.focus("#advance");
    for (const key of ["Enter", "Space", "Enter", "Space"]) await page.keyboard.press(key);
    await frames(page);
    const pushed = await inserted();
    await page.focus("#withdraw");
    for (const key of ["Enter", "Space"]) await page.keyboard.press(key);
    await frames(page);
    check("Enter and Space on + and − move the needle", Math.abs(pushed - 1) < 0.01 && Math.abs(await inserted() - 0.5) < 0.01, `${pushed.toFixed(2)} mm, then ${(await inserted()).toFixed(2)}; expected 1.00 and 0.50`);
    await page.focus("summary");
    await page.keyboard.press("Space");
    await frames(page, 2);
    check("Space on a heading folds its group", await page.$eval("details", ({ open }) => !open) && !(await state(page)).frozen, "and does not freeze");
    await page.keyboard.press("Space");

    await page.evaluate(() => document.activeElement.blur());
    await page.keyboard.press("Space");
    await wait("scanner.state().frozen");
    await page.keyboard.press("Space");
    await wait("!scanner.state().frozen");
    const at = millimetres(await state(page));
    await page.keyboard.down("Alt");
    await page.keyboard.press("d");
    await page.keyboard.up("Alt");
    await frames(page);
    check("keys with Alt are the browser's", (await state(page)).values.rock === 0, "the probe does not rock");
    const keys = { ArrowRight: "probe", ArrowUp: "probe", w: "tilt", a: "rock", e: "rotate", f: "press", PageDown: "advance" };
    for (const [key, moved] of Object.entries(keys)) {
        const before = JSON.stringify((await state(page))[moved] ?? (await state(page)).values[moved]);
        await page.keyboard.down(key);
        await pause(100);
        await page.keyboard.up(key);
        await frames(page, 3);
        const after = JSON.stringify((await state(page))[moved] ?? (await state(page)).values[moved]);
        if (before === after) check(`the key ${key} acts`, false, `${moved} stays ${before}`);
    }
    check("arrows slide the probe", String(at) !== String(millimetres(await state(page))), `${at.map((one) => one.toFixed(1))} -> ${millimetres(await state(page)).map((one) => one.toFixed(1))} mm`);

    const camera = () => page.evaluate(() => JSON.stringify([scanner.space.view.yaw, scanner.space.view.pitch, scanner.space.view.distance]));
    await page.focus("#anatomy");
    const home = await camera(), seen = new Set([home]);
    await page.keyboard.down("Shift");
    for (const key of ["ArrowLeft", "ArrowUp"]) { await page.keyboard.press(key); seen.add(await camera()); }
    await page.keyboard.up("Shift");
    for (const key of ["+", "-", "-"]) { await page.keyboard.press(key); seen.add(await camera()); }
    await page.keyboard.press("Home");
    check("keys turn and zoom the 3-D view", seen.size >= 5 && await camera() === home, `${seen.size} views, and Home returns`);
    await page.focus("#picture");
    for (let i = 0; i < 10; ++i) await page.keyboard.press("ArrowRight");
    const [from, to] = await page.evaluate(() => scanner.picture.calliper);
    await page.keyboard.press("Escape");
    check("keys measure in the picture", to.x - from.x === 20 && to.y === from.y && !await page.evaluate(() => scanner.picture.calliper), "20 pixels after ten arrows; Escape clears");
    await reset(page);
}

// Every control with its least, its greatest and a usual value; what was operated is compared with what the page has.
async function test_all_controls(page) {
    const wait_for = (name, value) => page.waitForFunction((event, wanted) => Math.abs(Math.abs(scanner.state().values[event]) - Math.abs(wanted)) < 2e-3 * Math.max(1, Math.abs(wanted)),
        { timeout: 60_000 }, name, value);
    await page.evaluate(() => document.querySelectorAll("details").forEach((group) => (group.open = true)));
    const sliders = await page.$$eval("input[type=range]", (all) => all.map(({ name, min, max, value }) => ({ name, low: Number(min), high: Number(max), first: Number(value) })));
    const wrong = [];
    for (const { name, low, high, first } of sliders) try {
        await page.focus(`input[name="${name}"]`);
        for (const [key, value] of [["End", high], ["Home", low], ["ArrowRight", undefined], ["Delete", first]]) {
            await page.keyboard.press(key);
            if (value !== undefined) await wait_for(name, value);
        }
    } catch (late) {
wrong.push(`${name}: ${(await state(page)).values[name]}; ${late.message}`);
    }
    check("each slider reaches its ends and returns", wrong.length === 0 && sliders.length > 40, wrong.join(" | ") || `${sliders.length} sliders`);
    for (const name of await page.$$eval("#choices select", (all) => all.map((one) => one.name)))
        for (let i = (await page.$$(`select[name=${name}] option`)).length - 1; i >= 0; --i) {
            await page.focus(`select[name=${name}]`);
            await page.keyboard.press(i === 0 ? "Home" : "ArrowDown");
            await frames(page, 1);
        }
    await page.focus('input[name="patient"]');
    await page.keyboard.press("ArrowUp");
    await wait_for("patient", 1);
    await reset(page);
    for (const button of await page.$$(".choice button")) {
        const [name, value] = await button.evaluate((one) => [one.name, [...one.parentNode.querySelectorAll("button")].indexOf(one)]);
        await button.click();
        await wait_for(name, value);
    }
    for (const summary of await page.$$("summary")) {
        await summary.click();
        await summary.click();
    }
    for (const tool of ["tilt", "rotate", "slide"]) {
        await page.click(`[data-tool=${tool}]`);
        const before = JSON.stringify((await state(page)).probe);
        await drag(page, "probe", 15, 10);
        if (before === JSON.stringify((await state(page)).probe)) check(`the tool ${tool} acts`, false, "the probe stays");
    }
    const seen = () => page.evaluate(() => {
        const { space } = scanner;
        space.place_camera();
        space.renderer?.render(space.scene, space.camera);
        return space.canvas.toDataURL();
    });
    await page.click("#freeze");
    await page.waitForFunction(() => scanner.state().frozen);
    const cut = await seen();
    await page.click("#cut");
    const whole = await seen();
    await page.keyboard.press("c");
    check("Cut and its key leave out what lies before the picture", cut !== whole && cut === await seen(), "the view changes and returns");
    await page.click("#freeze");
    const inserted = (await state(page)).values.advance;
    await page.click("#advance", { delay: 300 });
    await frames(page);
    const pushed = (await state(page)).values.advance;
    await page.click("#withdraw", { delay: 300 });
    await frames(page);
    check("+ and − act while they are held", pushed > inserted + 2 && (await state(page)).values.advance < pushed - 2, `${inserted.toFixed(1)} -> ${pushed.toFixed(1)} -> ${(await state(page)).values.advance.toFixed(1)} mm`);
    await page.click("#entry");
    await page.click("#entry");
    const picture = await page.$eval("#picture", (one) => one.getBoundingClientRect().toJSON());
    await page.mouse.move(picture.left + 0.4 * picture.width, picture.top + 0.4 * picture.height);
    await page.mouse.down();
    await page.mouse.move(picture.left + 0.6 * picture.width, picture.top + 0.5 * picture.height);
    await page.mouse.up();
    check("dragging on the picture measures", await page.evaluate(() => scanner.picture.calliper?.length === 2), "two ends");

    await page.click("#help");
    await page.click("#hint button");
    const [chooser] = await Promise.all([page.waitForFileChooser(), page.click("#open")]);
    await chooser.accept([file("choices.obj", box_object("choices", [40, 40, 30]))]);
    await page.waitForSelector("#load[open]");
    for (const select of await page.$$("#load select")) {
        const values = await select.evaluate((one) => [...one.options].map(({ value }) => value));
        for (const value of [values.at(-1), values[values.length >> 1], values[0]]) {
            await select.focus();
            await page.keyboard.press("Home");
            for (let i = values.indexOf(value); i > 0; --i) await page.keyboard.press("ArrowDown");
        }
    }
    for (const number of await page.$$("#load input[type=number]")) {
        await number.focus();
        for (const key of ["ArrowUp", "ArrowDown"]) await page.keyboard.press(key);
    }
    await page.click('#load button[value=""]');
    check("Cancel loads nothing", await page.$eval("#examination", ({ textContent }) => textContent.startsWith("Nerve")) && !await fault(page), "the phantom stays");
    await page.setViewport({ width: 390, height: 844 }); // the tabs are there
    for (const tab of await page.$$("#tabs button")) await tab.click();
    await page.setViewport({ width: 1280, height: 800 });

    const { missing, all } = await page.evaluate((selector) => {
        const list = [...document.querySelectorAll(selector)], name = (one) => one.name || one.id || one.dataset.tool || one.textContent;
        const complete = (one) => {
            const seen = window.operated.get(one);
            if (!seen) return false;
            if (one.type === "range") return seen.has(one.min) && seen.has(one.max) && seen.size > 2;
            if (one.tagName === "SELECT") return seen.has(one.options[0].value) && seen.has(one.options[one.options.length - 1].value);
            return true;
        };
        return { missing: list.filter((one) => !complete(one)).map((one) => `${one.tagName} ${name(one)}`), all: list.length };
    }, controls);
    check("the test has operated every control of the page", missing.length === 0, missing.join(", ") || `${all} controls`);
    await reset(page);
}

// What is covered by something else, or outside of the window and of what scrolls.
const covered = (page) => page.$$eval(controls, (all) => all.filter((one) => one.checkVisibility() && !one.closest("dialog")).filter((one) => {
    const box = one.getBoundingClientRect(), x = box.left + box.width / 2, y = box.top + box.height / 2;
    const scrolled = one.closest("#controls, #groups, #tabs") && (() => {
        one.scrollIntoView({ block: "center", inline: "center" });
        return true;
    })();
    const now = scrolled ? one.getBoundingClientRect() : box;
    return [[x, y], [box.left + 3, y], [box.right - 3, y]].some((_, i) => {
        const at = document.elementFromPoint([now.left + now.width / 2, now.left + 3, now.right - 3][i], now.top + now.height / 2);
        return !one.contains(at) && !at?.contains(one.closest("label") ?? one);
    });
}).map((one) => one.name || one.id || one.textContent));

async function test_layout(page) {
    const sizes = [[320, 568], [360, 740], [390, 844], [568, 320], [740, 360], [844, 390], [600, 800], [768, 1024], [825, 600], [900, 700], [1000, 700], [1100, 800], [1280, 800], [1920, 1080]];
    for (const [width, height] of sizes) {
        await page.setViewport({ width, height });
        await pause(300);
        const hidden = await covered(page);
        const { wide, picture, anatomy, crossing } = await page.evaluate(() => {
            const box = (name) => document.getElementById(name).getBoundingClientRect();
            const [a, b] = [box("picture"), box("anatomy")], tools = box("tools"), panel = box("controls");
            const overlap = (p, q) => p.left < q.right - 1 && q.left < p.right - 1 && p.top < q.bottom - 1 && q.top < p.bottom - 1;
            return { wide: document.documentElement.scrollWidth, picture: Math.min(a.width, a.height), anatomy: Math.min(b.width, b.height),
                crossing: [[a, b], [a, tools], [a, panel], [b, tools], [b, panel], [tools, panel]].filter(([p, q]) => overlap(p, q)).length };
        });
        check(`all controls can be used at ${width} x ${height}`, hidden.length === 0 && wide <= width && picture >= 100 && anatomy >= 75 && crossing === 0,
            `covered: ${hidden.join(", ") || "none"}; picture ${picture.toFixed(0)}, 3-D view ${anatomy.toFixed(0)} pixels; ${crossing} overlaps; ${wide} pixels wide`);
        await screenshot(page, `${width}x${height}.png`);
    }
    await page.setViewport({ width: 1280, height: 800 });
}

// A session that takes its time to load, while a user already touches everything.
async function test_loading(browser) {
    const slow = await serve(site, {}, async () => await pause(4000) ?? true), broken = await serve(site, {}, async () => false);
    const page = await visit(browser, slow.url, { width: 1280, height: 800 });
    const before = errors.length;
    await page.waitForSelector("#hint[open]");
    await page.click("#hint button");
    for (const name of ["#freeze", "#reset", "[data-tool=tilt]", "#advance", "#withdraw", "#picture", "#anatomy"]) {
        const box = await page.$eval(name, (one) => one.getBoundingClientRect().toJSON());
        await page.mouse.click(box.left + box.width / 2, box.top + box.height / 2);
    }
    for (const key of ["Tab", "Enter", "Space", "Tab", "Tab", "Space", "ArrowLeft", "PageDown", "Space"]) await page.keyboard.press(key);
    await page.evaluate(() => document.getElementById("hint").open && document.getElementById("hint").close());
    await (await page.$("#file")).uploadFile(file("early.obj", box_object("early", [40, 40, 30])));
    const early = await page.evaluate(() => window.scanner === undefined);
    await running(page);
    await page.waitForSelector("#load[open]");
    await page.click('#load button[value="load"]');
    await page.waitForFunction(() => document.getElementById("examination").textContent === "early.obj", { timeout: 60_000 });
    await frames(page);
    check("whatever is pressed before the session is there does no harm", early && errors.length === before && !(await state(page)).frozen, errors.slice(before).join(" | ") || "and a file that is opened then is loaded");
    await page.close();

    const dead = await visit(browser, broken.url, { width: 1280, height: 800 });
    const sentence = await (await dead.waitForSelector("#fault:not([hidden]) span")).evaluate((span) => span.textContent);
    check("a session that cannot be loaded gives a sentence", /did not start: /.test(sentence), sentence);
    await dead.close();
    for (const { server } of [slow, broken]) server.close();
    errors.length = before; // the browser's own, of what was missing
}

// A browser that blocks cookies, and with them storage, and WebGL.
async function test_refusals(url) {
    const profile = path.join(scratch, "profile");
    fs.mkdirSync(path.join(profile, "Default"), { recursive: true });
    fs.writeFileSync(path.join(profile, "Default", "Preferences"), JSON.stringify({ profile: { default_content_setting_values: { cookies: 2 } } }));
    const browser = await puppeteer.launch({ ...launch, userDataDir: profile, args: ["--no-sandbox", "--disable-dev-shm-usage", "--disable-3d-apis"] });
    const before = errors.length;
    try {
        const page = await open(browser, url, { width: 1280, height: 800 });
        const blocked = await page.evaluate(() => { try { return String(localStorage.length); } catch ({ name }) { return name; } });
        await page.click("#hint button");
        check("the page works without storage", blocked === "SecurityError" && await page.$eval("#hint", ({ open: shown }) => !shown), `localStorage gives ${blocked}`);
        const sentence = await wait_for_fault(page);
        await page.click("#freeze");
        await page.waitForFunction(() => scanner.state().frozen, { timeout: 60_000 });
        check("... and without WebGL, in words", /WebGL/.test(sentence), sentence);
        const thrown = errors.slice(before).filter((one) => !/WebGL/.test(one));
        check("... and throws nothing", thrown.length === 0, thrown.join(" | ") || "no error");
        const file_page = await browser.newPage();
        await file_page.goto(`file://${path.resolve(site, "index.html")}`);
        await file_page.waitForFunction(() => /web server/.test(document.getElementById("loading").textContent), { timeout: 20_000 });
        check("opened as a file, the page says what it needs", true, await file_page.$eval("#loading", ({ textContent }) => textContent));
    } finally {
        errors.length = before;
        await browser.close();
    }
}

async function screenshot(page, name) {
    if (option("--screenshots")) await page.screenshot({ path: path.join(option("--screenshots"), name) });
}

const files = ["index.html", "style.css", "page.js", "session_worker.js", "scanner.js", "scanner.wasm"];
const sizes = files.map((name) => gzipSync(fs.readFileSync(path.join(site, name)), { level: 9 }).length);
const total = sizes.reduce((sum, one) => sum + one, 0);
check("size, gzip -9", total < 600_000, `${(total / 1000).toFixed(0)} kB; expected < 600: ${files.map((name, i) => `${name} ${(sizes[i] / 1000).toFixed(1)}`).join(", ")}`);

const launch = {
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", protocolTimeout: 300_000,
    args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage"],
};
const browser = await puppeteer.launch(launch);
try {
    const plain = await serve(site, {});
    const isolating = await serve(site, { "cross-origin-opener-policy": "same-origin", "cross-origin-embedder-policy": "require-corp" });
    await test_loading(browser);
    await test_refusals(plain.url);
    const page = await open(browser, plain.url.replace("127.0.0.1", "localhost"), { width: 1280, height: 800 });
    check("the first visit shows a hint", await page.$eval("#hint", ({ open }) => open), "open");
    await screenshot(page, "hint.png");
    await page.click("#hint button");
    await test_controls(page);
    await test_cases(page);
    await test_files(page);
    await test_recordings(page);
    await test_space(page);
    await test_milliseconds(page);
    await test_keyboard(page);
    await test_all_controls(page);
    await test_layout(page);
    await test_rate(browser, page);
    for (const line of ["entry -23 0", "steepness 33", "advance 21"]) await page.evaluate((event) => scanner.send(event), line);
    await frames(page);
    await screenshot(page, "desktop.png");
    if (option("--replay")) {
        const isolated = await open(browser, isolating.url, { width: 1280, height: 800 });
        await test_replay(page, isolated);
        await isolated.close();
    }
    await page.close();
    const context = await browser.createBrowserContext();
    const phone = await open(context, plain.url, { width: 390, height: 844, deviceScaleFactor: 2, isMobile: true, hasTouch: true });
    await test_touch(phone);
    await screenshot(phone, "phone.png");
    check("no console error", errors.length === 0, errors.join(" | ") || "none");
    plain.server.close();
    isolating.server.close();
} catch (fault) {
    check("the test ran to its end", false, `${fault.stack}\n${errors.join("\n")}`);
} finally {
    await browser.close();
    fs.rmSync(scratch, { recursive: true });
}
process.exit(failed ? 1 : 0);
