// Tests the page in headless Chromium: node test.mjs SITE [--replay PROGRAM FILE] [--rate FRAMES_PER_SECOND] [--screenshots FOLDER]
//
// --replay compares the pictures of a recorded session with those of live_replay; --rate fails where the page is slower.
import { spawnSync } from "node:child_process";
import fs from "node:fs";
import http from "node:http";
import { createRequire } from "node:module";
import os from "node:os";
import path from "node:path";
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
function serve(folder, headers) {
    const server = http.createServer((request, response) => {
        const name = decodeURI(request.url.split("?")[0]), file = path.join(folder, name.endsWith("/") ? `${name}index.html` : name);
        if (!fs.existsSync(file)) return response.writeHead(404).end();
        response.writeHead(200, { "content-type": types[path.extname(file)] ?? "text/plain", ...headers }).end(fs.readFileSync(file));
    });
    return new Promise((ready) => server.listen(0, "127.0.0.1", () => ready({ server, url: `http://127.0.0.1:${server.address().port}/` })));
}

const errors = [];
async function open(browser, url, viewport) {
    const page = await browser.newPage();
    page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
    page.on("pageerror", (error) => errors.push(String(error?.message ?? error)));
    await page.setViewport(viewport);
    await page.goto(url);
    await page.waitForFunction(() => window.scanner?.state()?.frame > 2, { timeout: 120_000 });
    return page;
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
    await new Promise((then) => setTimeout(then, 400));
    check("frozen, nothing is drawn", (await state(page)).frame === frozen.frame, `frame ${frozen.frame} stays`);
    await page.click("#freeze");
    await page.waitForFunction(() => !scanner.state().frozen);
    await page.click("#reset");
    await frames(page);
}

async function test_files(page) {
    const file = (name, text) => {
        const at = path.join(scratch, name);
        fs.writeFileSync(at, text);
        return at;
    };
    const pick = async (name) => {
        await (await page.$("#file")).uploadFile(name);
        await page.waitForSelector("#load[open]");
        await page.click('#load button[value="load"]');
        await page.waitForFunction(() => !document.getElementById("load").open);
    };
    await pick(file("broken.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n"));
    await page.waitForSelector("#fault:not([hidden])");
    const sentence = await page.$eval("#fault span", (span) => span.textContent);
    check("a broken OBJ file gives a sentence", /broken\.obj:4: /.test(sentence), sentence);
    await frames(page);
    const kept = await look(page);
    check("... and the session goes on", kept.bright > 0.2, `${(100 * kept.bright).toFixed(0)} % of pixels above 20`);

    const [x, y, z] = [40, 40, 30]; // a box, mm
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((i) => `v ${i & 1 ? x : 0} ${i & 2 ? y : 0} ${i & 4 ? z : 0}`);
    await pick(file("box.obj", `${corners.join("\n")}\nf 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n`));
    await page.waitForFunction(() => document.getElementById("examination").textContent === "box.obj");
    await frames(page);
    const seen = await look(page), width = seen.grey.length / (await state(page)).height;
    const depth = 1e3 * (await state(page)).pitch, row = Math.round(29.6 / depth);
    const below = seen.grey.subarray(width * Math.round(35 / depth)).reduce((sum, one) => sum + one, 0) / (seen.grey.length - width * Math.round(35 / depth));
    check("an OBJ file is scanned", seen.mean > 20 && below < 0.5 * seen.mean, `mean level ${seen.mean.toFixed(1)}, below the box ${below.toFixed(1)}; its far side is at row ${row}`);
    await page.click("#reset");
    await frames(page);
}

async function test_rate(browser, page) {
    const processes = await (await browser.target().createCDPSession());
    const cpu = async () => (await processes.send("SystemInfo.getProcessInfo")).processInfo.reduce((sum, one) => sum + one.cpuTime, 0);
    await frames(page, 10);
    const begin = performance.now(), from = (await state(page)).frame, busy = await cpu();
    await new Promise((then) => setTimeout(then, 4000));
    const { frame, values, seconds } = await state(page), drawn = frame - from;
    const rate = (1000 * drawn) / (performance.now() - begin), least = Number(option("--rate") ?? 0);
    check("frames per second", rate >= least, `${rate.toFixed(1)} at ${values.lines} lines, ${values.planes} plane(s), at most 30; expected >= ${least}; ` +
        `session ${(1e3 * seconds).toFixed(0)} ms, browser ${((1000 * (await cpu() - busy)) / drawn).toFixed(0)} ms of CPU a frame; load ${os.loadavg()[0].toFixed(1)} on ${os.cpus().length} cores`);
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

async function screenshot(page, name) {
    if (option("--screenshots")) await page.screenshot({ path: path.join(option("--screenshots"), name) });
}

const files = ["index.html", "style.css", "page.js", "session_worker.js", "scanner.js", "scanner.wasm"];
const sizes = files.map((name) => gzipSync(fs.readFileSync(path.join(site, name)), { level: 9 }).length);
const total = sizes.reduce((sum, one) => sum + one, 0);
check("size, gzip -9", total < 500_000, `${(total / 1000).toFixed(0)} kB; expected < 500: ${files.map((name, i) => `${name} ${(sizes[i] / 1000).toFixed(1)}`).join(", ")}`);

const browser = await puppeteer.launch({
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", protocolTimeout: 300_000,
    args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage"],
});
try {
    const plain = await serve(site, {});
    const isolating = await serve(site, { "cross-origin-opener-policy": "same-origin", "cross-origin-embedder-policy": "require-corp" });
    const page = await open(browser, plain.url, { width: 1280, height: 800 });
    check("the first visit shows a hint", await page.$eval("#hint", ({ open }) => open), "open");
    await screenshot(page, "hint.png");
    await page.click("#hint button");
    await test_controls(page);
    await test_files(page);
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
    const phone = await open(browser, plain.url.replace("127.0.0.1", "localhost"), { width: 390, height: 844, deviceScaleFactor: 2, isMobile: true, hasTouch: true });
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
