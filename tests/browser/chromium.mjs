// SPDX-License-Identifier: MIT
//
// A page in headless Chromium with WebGL 2 by ANGLE over SwiftShader, for tests that node runs. Talks to the browser by
// the DevTools protocol over a pipe, so it needs nothing but node.
import {spawn} from 'node:child_process';
import {mkdtempSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {createServer} from 'node:http';
import {tmpdir} from 'node:os';
import {join, normalize} from 'node:path';

const patience = Number(process.env.PHYMUL_PATIENCE || 1);  // on a busy machine, waits are so many times as long
export const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

/// Collects what does not hold; finish() ends the program, with 1 where something does not.
export class Expectations {
  failed = 0;
  expect = (holds, text) => {
    console.log(`${holds ? 'ok' : 'FAILED'}: ${text}`);
    if (!holds) ++this.failed;
  };
  finish = () => {
    if (this.failed) console.error(`${this.failed} failed`);
    process.exit(this.failed ? 1 : 0);
  };
}

const types = {html: 'text/html', js: 'text/javascript', css: 'text/css', wasm: 'application/wasm'};

/// A server of a folder's files; `home`, if given, is the text of its first page.
export async function serve(folder, home) {
  const missing = [];
  const server = createServer((request, response) => {
    const name = normalize(request.url.split('?')[0]).replace(/^\/$/, '/index.html');
    try {
      const bytes = name === '/index.html' && home !== undefined ? home : readFileSync(join(folder, name));
      response.writeHead(200, {'Content-Type': types[name.split('.').at(-1)] || 'application/octet-stream'}).end(bytes);
    } catch {
      response.writeHead(404).end();
      missing.push(name);
    }
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  return {address: `http://127.0.0.1:${server.address().port}/`, missing, close: () => server.close()};
}

export class Page {
  errors = [];        // of the page's scripts and the browser's console
  onLine = () => {};  // called with each line that the page logs
  #profile = mkdtempSync(join(tmpdir(), 'phymul-page-'));
  #browser;
  #session;
  #next = 0;
  #waiting = new Map();
  #gone;  // a promise: how the browser ended
  #end;   // that sentence, once it has

  static async open(chromium, address, width, height) {
    const page = new Page();
    page.#browser = spawn(chromium, ['--headless', '--no-sandbox', '--disable-background-networking',
      '--disable-component-update', '--disable-sync', '--no-first-run', '--disable-gpu-watchdog', '--use-gl=angle',
      '--use-angle=swiftshader', '--enable-unsafe-swiftshader', `--user-data-dir=${page.#profile}`,
      '--remote-debugging-pipe', 'about:blank'], {stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe']});
    page.#gone = new Promise((resolve) => {
      page.#browser.once('error', (error) => resolve(`${chromium} does not start: ${error.message}`));
      page.#browser.once('exit', (code) => resolve(`${chromium} ended with ${code}`));
    });
    page.#gone.then((why) => page.#fail(why));
    let left = '';
    page.#browser.stdio[4].setEncoding('utf8').on('data', (data) => {  // messages end with a zero byte
      const parts = (left + data).split('\0');
      left = parts.pop();
      for (const part of parts) page.#receive(JSON.parse(part));
    });
    page.#browser.stdio[3].on('error', () => {});  // the exit tells
    try {
      const {targetInfos} = await page.send('Target.getTargets');
      const {targetId} = targetInfos.find((target) => target.type === 'page');
      ({sessionId: page.#session} = await page.send('Target.attachToTarget', {targetId, flatten: true}));
      for (const domain of ['Page', 'Runtime', 'Log', 'Inspector']) await page.send(`${domain}.enable`);
      await page.resize(width, height);
      await page.send('Page.navigate', {url: address});
    } catch (error) {
      await page.close();
      throw error;
    }
    return page;
  }

  #fail(text) {
    this.#end = text;
    for (const {reject} of this.#waiting.values()) reject(new Error(text));
    this.#waiting.clear();
  }

  #receive(message) {
    const {method, params} = message;
    if (message.id && this.#waiting.has(message.id)) {
      const {asked, resolve, reject} = this.#waiting.get(message.id);
      this.#waiting.delete(message.id);
      if (message.error) reject(new Error(`${asked}: ${message.error.message}`));
      else resolve(message.result);
    } else if (method === 'Inspector.targetCrashed') {
      this.#fail('the page crashed');
    } else if (method === 'Runtime.exceptionThrown') {
      this.errors.push(params.exceptionDetails.exception?.description || params.exceptionDetails.text);
    } else if (method === 'Runtime.consoleAPICalled') {
      const line = params.args.map((a) => a.value ?? a.description).join(' ');
      if (['error', 'warning'].includes(params.type)) this.errors.push(line);
      else this.onLine(line);
    } else if (method === 'Log.entryAdded' && ['error', 'warning'].includes(params.entry.level)) {
      this.errors.push(params.entry.text);
    }
  }

  send(method, params = {}) {
    return new Promise((resolve, reject) => {
      if (this.#end) return reject(new Error(this.#end));
      this.#waiting.set(++this.#next, {asked: method, resolve, reject});
      this.#browser.stdio[3].write(JSON.stringify({id: this.#next, method, params, sessionId: this.#session}) + '\0');
    });
  }

  async evaluate(expression) {
    const {result, exceptionDetails} = await this.send('Runtime.evaluate', {expression, returnByValue: true, awaitPromise: true});
    if (exceptionDetails) {
      throw new Error(`${expression}: ${exceptionDetails.exception?.description || exceptionDetails.text}`);
    }
    return result.value;
  }

  /// Waits for an expression to hold; `said` is one that tells what the page shows where it does not.
  async until(expression, seconds, what, said = '""') {
    for (const end = Date.now() + 1000 * patience * seconds; Date.now() < end; await pause(200)) {
      if (await this.evaluate(`Boolean(${expression})`)) return;  // an object may be too large to be told
    }
    throw new Error(`${what}: not within ${patience * seconds} s; the page says "${await this.evaluate(said)}"`);
  }

  resize(width, height, mobile = false) {
    return this.send('Emulation.setDeviceMetricsOverride', {width, height, deviceScaleFactor: 1, mobile});
  }

  async screenshot(file) {
    const {data} = await this.send('Page.captureScreenshot', {format: 'png', captureBeyondViewport: true});
    writeFileSync(file, Buffer.from(data, 'base64'));
  }

  async close() {
    this.#session = undefined;
    this.send('Browser.close').catch(() => {});
    await this.#gone;
    rmSync(this.#profile, {recursive: true, force: true, maxRetries: 5});
  }
}
