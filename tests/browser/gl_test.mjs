// SPDX-License-Identifier: MIT
//
// gl_test.mjs CHROMIUM FOLDER [GoogleTest's options]: runs FOLDER/phymul_browser_gl_test.js in headless Chromium. Fails
// unless tests were run and all passed; of tests that skip themselves it tells.
import {Expectations, Page, serve} from './chromium.mjs';

const [chromium, folder, ...options] = process.argv.slice(2);
const {expect, finish} = new Expectations();
const server = await serve(folder, '<!doctype html><link rel="icon" href="data:,"><script src="phymul_browser_gl_test.js"></script>');
const lines = [];
let page;
try {
  page = await Page.open(chromium, server.address, 400, 400);
  page.onLine = (line) => {
    lines.push(line);
    console.log(line);
  };
  await page.until('window.createTests', 60, 'the program is loaded');
  await page.evaluate(`createTests({arguments: ${JSON.stringify(options)}, print: console.log, printErr: console.log,
    preRun: [(module) => { module.ENV.PHYMUL_REQUIRE_GL = '1'; }]}).then(() => 0)`);
} catch (error) {
  expect(false, error.message);
} finally {
  await page?.close();
  server.close();
}
const passed = lines.find((line) => /\[  PASSED  \] [1-9]/.test(line));
expect(passed && !lines.some((line) => line.includes('[  FAILED  ]')), `the tests pass in the browser: ${passed || 'none ran'}`);
expect(!page?.errors.length, `the browser's console has no errors: ${page?.errors.slice(0, 3).join('; ') || 'none'}`);
finish();
