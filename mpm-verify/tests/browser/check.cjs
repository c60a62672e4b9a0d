// Checks pages: HTML by html-validate, accessibility by axe, and what a reader sees at three widths, light and dark.
// node check.cjs BROWSER PAGE... ; needs puppeteer-core, axe-core and html-validate in NODE_PATH. Prints one line per fault.
const fs = require('fs');
const puppeteer = require('puppeteer-core');
const { HtmlValidate } = require('html-validate');
const axe = fs.readFileSync(require.resolve('axe-core/axe.min.js'), 'utf8');

const [browserPath, ...pages] = process.argv.slice(2);
const rules = {
  extends: ['html-validate:recommended'],
  rules: { 'long-title': 'off', 'no-trailing-whitespace': 'off', 'void-style': 'off', 'no-inline-style': 'off', 'prefer-native-element': 'off' },
};

const WIDTHS = [390, 768, 1440];

// Entries of legends without which their picture looks the same.
async function unseen(page) {
  const found = [];
  for (const figure of await page.$$('figure:has([data-l])')) {
    if (!await figure.isVisible()) continue;
    const drawing = await figure.$('svg');
    const whole = await drawing.screenshot();
    for (const number of await drawing.$$eval('[data-l]', entries => entries.map(entry => entry.dataset.l))) {
      const show = shown => drawing.$$eval(`[data-s="${number}"]`, (series, shown) => series.forEach(s => s.style.display = shown), shown);
      await show('none');
      if (Buffer.compare(whole, await drawing.screenshot()) === 0) {
        found.push(await drawing.$eval(`[data-l="${number}"]`, entry => entry.getAttribute('aria-label')));
      }
      await show('');
    }
  }
  return found;
}

(async () => {
  const validator = new HtmlValidate(rules);
  for (const file of pages) {
    const report = await validator.validateString(fs.readFileSync(file, 'utf8'));
    for (const m of report.results.flatMap(result => result.messages)) {
      console.log(`${file}:${m.line}: ${m.ruleId}: ${m.message}`);
    }
    const size = fs.statSync(file).size;
    if (size > 1.5e6) console.log(`${file}: ${size} bytes, at most 1.5 MB`);
  }
  const browser = await puppeteer.launch({ executablePath: browserPath, args: ['--no-sandbox', '--disable-gpu'] });
  for (const file of pages) {
    for (const width of WIDTHS) {
      for (const theme of ['light', 'dark']) {
        const page = await browser.newPage();
        const say = fault => console.log(`${file} at ${width} px, ${theme}: ${fault}`);
        page.on('pageerror', error => say(`script: ${error.message}`));
        page.on('request', request => {
          if (!/^(file|data|blob):/.test(request.url())) say(`asks for ${request.url()}`);
        });
        await page.emulateMediaFeatures([{ name: 'prefers-color-scheme', value: theme }]);
        await page.setViewport({ width, height: 900 });
        await page.goto(`file://${file}`, { waitUntil: 'load' });
        const seen = await page.evaluate(() => ({
          load: performance.timing.loadEventStart - performance.timing.navigationStart,
          wide: document.documentElement.scrollWidth - document.documentElement.clientWidth,
          high: document.documentElement.scrollHeight,
          hidden: [...document.querySelectorAll('.verdict .badge, td:nth-child(2) > .badge')].filter(badge => {
            const { right, width } = badge.getBoundingClientRect();
            return width > 0 && right > innerWidth;
          }).length,
          cells: [...document.querySelectorAll('td')].filter(cell => {
            const { width } = cell.getBoundingClientRect();
            return width > 0 && width < 110 && cell.textContent.length > 80;
          }).map(cell => cell.textContent.slice(0, 40)),
          tables: [...document.querySelectorAll('.table')].map(box => [...box.querySelectorAll('*')].concat(box)
            .filter(e => getComputedStyle(e).overflowX === 'auto').map(e => [e.scrollWidth, e.clientWidth]).find(([all, seen]) => all > seen + 1))
            .filter(Boolean).map(([all, seen]) => `${all} px in ${seen} px`),
          levels: [...document.querySelectorAll('h1, h2, h3, h4')].map(h => +h.tagName[1]),
        }));
        if (seen.wide > 0) say(`scrolls sideways by ${seen.wide} px`);
        if (seen.cells.length) say(`cells of long text in narrow columns: ${seen.cells}`);
        if (seen.tables.length && width === 1440) say(`tables wider than their boxes: ${seen.tables}`);
        await page.evaluate(() => document.querySelectorAll('details').forEach(details => details.open = true));
        if (width === 1440 && theme === 'light') for (const label of await unseen(page)) say(`in the legend and nowhere to be seen: ${label}`);
        if (seen.high > 12000 && width === 1440) say(`${seen.high} px high, at most 12 000`);
        if (seen.hidden) say(`${seen.hidden} verdicts are off the screen`);
        if (seen.load > 1000) say(`loads in ${seen.load} ms, at most 1000`);
        if (seen.levels.some((level, k) => level > (seen.levels[k - 1] || 0) + 1)) say(`headings jump: ${seen.levels}`);
        await page.evaluate(axe);
        const { violations } = await page.evaluate(() => axe.run(document, { resultTypes: ['violations'] }));
        for (const v of violations) say(`${v.id}: ${v.help} (${v.nodes.length}): ${v.nodes[0].html.slice(0, 160)}`);
        await page.close();
      }
    }
  }
  await browser.close();
})().catch(error => { console.log(String(error.stack)); process.exit(1); });
