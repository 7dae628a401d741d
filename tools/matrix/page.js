// The page of tools/matrix/run.py: data holds meta figures, tables and what the charts draw.
const data = JSON.parse(document.getElementById("data").textContent);
const {groups, measures, odometry, worlds, curves} = data.charts;
const odometryColor = {true: "var(--truth)", excellent: "var(--corrected)", good: "var(--found)", poor: "var(--ghost)"};
const worldColors = ["var(--found)", "var(--missed)", "var(--corrected)", "var(--odometry)", "var(--ghost)", "var(--moving)"];
const mean = (list) => list.reduce((a, b) => a + b, 0) / list.length;

/** A row a world, a dot a mean over the seeds with their range, a colour an odometry quality. */
function dotPlot(measure) {
  const W = 560, left = 96, right = 20, rowHeight = 20 + 9 * odometry.length, H = worlds.length * rowHeight + 30;
  const all = groups.flatMap((g) => g[measure]);
  if (!all.length) return el("p", {class: "none"}, "not yet");
  const top = measure === "F1" ? 1 : Math.max(...all) * 1.04 || 1, X = (v) => left + (v / top) * (W - left - right);
  const svg = el("svg:svg", {viewBox: `0 0 ${W} ${H}`, role: "img"});
  for (const x of ticks(0, top, 6)) {
    svg.append(el("svg:path", {class: x === 0 ? "axis base" : "axis", d: `M${X(x)} 4V${H - 24}`}),
      el("svg:text", {x: X(x), y: H - 8, "text-anchor": "middle"}, String(x)));
  }
  worlds.forEach((world, i) => {
    const y0 = i * rowHeight + 8;
    svg.append(el("svg:text", {class: "strong", x: left - 10, y: y0 + rowHeight / 2, "text-anchor": "end"}, world));
    if (i) svg.append(el("svg:path", {class: "axis", d: `M0 ${y0 - 4}H${W - right}`}));
    odometry.forEach((name, k) => {
      const values = (groups.find((g) => g.world === world && g.odometry === name) || {})[measure] || [];
      if (!values.length) return;
      const y = y0 + 8 + k * 9, low = Math.min(...values), high = Math.max(...values), color = odometryColor[name];
      svg.append(hover(el("svg:g", {}, el("svg:path", {d: `M${X(low)} ${y}H${X(high)}`, stroke: color, "stroke-width": 2.5, opacity: 0.5, "stroke-linecap": "round"}),
        el("svg:circle", {cx: X(mean(values)), cy: y, r: 4.4, fill: color, stroke: "var(--card)", "stroke-width": 1.2})),
        `${world}, ${name} odometry\n${measure}: ${show(mean(values))}\n${values.length} seeds, ${show(low)} to ${show(high)}`));
    });
  });
  return svg;
}

function curveCard(title, note, value, unit) {
  const series = curves.filter((c) => c[value].length).map((c) => ({name: c.world, points: c[value], color: worldColors[worlds.indexOf(c.world) % 6]}));
  return card("", title, note, legend(series.map((s) => key(s.color, s.name))),
    series.length ? lineChart(series, {x: "frame", y: unit}) : el("p", {class: "none"}, "not run"));
}

function tableCard(table) {
  const cell = (value, i) => el("td", {class: (i < table.left ? "left" : "") + (/^(not yet|not run|–)$/.test(value) ? " none" : "")}, String(value));
  const same = (row, before) => before && row[0] === before[0];
  return card("wide", table.title, table.text.trim(), el("div", {class: "scroll"}, el("table", {},
    el("tr", {}, table.header.map((h, i) => el("th", {class: i < table.left ? "left" : ""}, h))),
    table.rows.map((row, r) => el("tr", {}, row.map((v, i) => cell(i === 0 && same(row, table.rows[r - 1]) ? "" : v, i)))))),
    el("p", {class: "note"}, el("code", {}, `${data.script} --only ${table.name}`)));
}

document.title = "Evaluation of hggmap";
document.querySelector("main").replaceChildren(
  el("header", {}, el("div", {}, el("h1", {}, "Evaluation"), el("p", {class: "sub"}, `${data.machine} · ${data.commit} · ${data.date} · seeds ${data.seeds} · ${data.frames}`),
    el("p", {class: "sub"}, el("code", {}, data.command))), themeButton()),
  el("div", {class: "grid"},
    card("wide", "Worlds and odometry", "Dot: mean over the seeds; line: from the worst to the best of them.", legend(odometry.map((name) => key(odometryColor[name], `${name} odometry`, "box")))),
    measures.map((measure) => card("", measure, "", dotPlot(measure))),
    curveCard("Time per frame", "Mean of neighbouring frames, one replay alone on the machine. Must not grow with the map.", "time", "ms"),
    curveCard("Map size", "Must level off where the robot has been before.", "memory", "MB"),
    data.tables.map(tableCard)),
  el("footer", {}, "Made by tools/matrix/run.py; everything is in this one file."));
document.body.append(tip);
