// Draws the pictures of a report: specifications and numbers lie in the page as JSON, Vega and three.js draw them, each
// when it comes near the screen. Without this script every picture remains the table below it, which then stands open.
(function () {
  'use strict';
  const kPlainMarks = 1500;  // more rows than these are drawn as pixels, not as elements
  const kNarrow = 480;       // px: below, a name stands above its bar
  const templates = JSON.parse(document.getElementById('templates').textContent);
  const darkness = window.matchMedia('(prefers-color-scheme: dark)');
  let printing = false;

  // Colours of Okabe and Ito: distinguished by people who see fewer colours. Groups differ in shape as well.
  function theme() {
    const dark = darkness.matches && !printing;
    return {
      ink: dark ? '#e6e6e6' : '#222222',
      paper: dark ? '#16181c' : '#ffffff',
      line: dark ? '#4a4f57' : '#cccccc',
      blue: dark ? '#56b4e9' : '#0072b2',
      red: dark ? '#e69f00' : '#d55e00',
      category: dark ? ['#56b4e9', '#e69f00', '#009e73', '#cc79a7', '#f0e442', '#d55e00']
                     : ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#e69f00', '#56b4e9', '#000000'],
    };
  }

  function vegaConfig(colours) {
    const text = {labelColor: colours.ink, titleColor: colours.ink, labelFont: 'sans-serif', titleFont: 'sans-serif',
      titleFontWeight: 'normal', labelFontSize: 11, titleFontSize: 12};
    return {
      background: 'transparent',
      axis: {...text, domainColor: colours.ink, tickColor: colours.ink, gridColor: colours.line, gridOpacity: 0.7},
      legend: text,
      title: {color: colours.ink, font: 'sans-serif', fontSize: 11, fontWeight: 'normal'},
      text: {font: 'sans-serif', fontSize: 11},
      range: {category: colours.category,
        symbol: ['circle', 'triangle-up', 'square', 'diamond', 'cross', 'triangle-down', 'stroke']},
    };
  }

  // {name: [..], ..} to [{name: .., ..}, ..]
  function rowsOf(columns) {
    const names = Object.keys(columns);
    return (columns[names[0]] || []).map((_, i) => Object.fromEntries(names.map((name) => [name, columns[name][i]])));
  }

  // Of a scatter the points of the columns that are chosen, and its axes: up to three times what 95 % of the points reach.
  // What is farther lies at the edge, framed; groups of few points lie on top, larger. Made here and not by expressions
  // of the template, which need ten times as long for each point.
  function pointsOf(picture, choice, colours) {
    const {rows} = picture.data, groups = rows[choice.colour] || [], points = [], members = {};
    const us = rows[choice.x] || [], vs = rows[choice.y] || [];
    us.forEach((u, i) => {
      const v = vs[i], group = groups[i] === undefined || groups[i] === null ? '' : groups[i];
      if (u === null || v === undefined || v === null) return;
      members[group] = (members[group] || 0) + 1;
      points.push({u, v, group, pose: rows.pose ? rows.pose[i] : null, id: rows.id ? rows.id[i] + ': ' : ''});
    });
    const sizes = Float64Array.from(points, (point) => Math.abs(point.v)).sort();
    const usual = sizes[Math.floor(0.95 * (sizes.length - 1))], most = sizes[sizes.length - 1];
    const reach = (usual > 0 ? Math.min(most, 3 * usual) : most) || 1;
    const along = [Infinity, -Infinity];
    let least = 0, beyond = 0;
    for (const point of points) {
      const isFar = Math.abs(point.v) > reach, isOfFew = members[point.group] < 0.2 * points.length;
      along[0] = Math.min(along[0], point.u);
      along[1] = Math.max(along[1], point.u);
      least = Math.min(least, point.v);
      beyond += isFar;
      point.at = Math.max(-reach, Math.min(reach, point.v));
      point.edge = isFar ? colours.ink : null;
      point.opacity = isOfFew ? 1 : 0.6;
      point.area = isOfFew ? 60 : 22;  // px^2
      point.words = point.id + Number(point.v.toPrecision(4)) + ' at ' + Number(point.u.toPrecision(4));
    }
    points.sort((a, b) => members[b.group] - members[a.group]);
    const curve = picture.settings.joined ? [...points].sort((a, b) => a.u - b.u) : [];
    return {
      data: {rows: points, curve},
      signals: {along: points.length ? along : [0, 1], across: [least < 0 ? -reach : 0, reach], beyond},
    };
  }

  // The template with its data, the values of its signals, and a menu for each signal that has one.
  function specificationOf(picture, colours) {
    const spec = JSON.parse(JSON.stringify(templates[picture.kind]));
    spec.padding = 4;
    spec.autosize = {type: 'fit-x', contains: 'padding'};
    let most = 0;
    for (const set of spec.data) {
      if (picture.kind === 'scatter' || !(set.name in picture.data)) continue;
      set.values = rowsOf(picture.data[set.name]);
      most = Math.max(most, set.values.length);
    }
    for (const signal of spec.signals) {
      if (signal.name in picture.settings) signal.value = picture.settings[signal.name];
      const menu = picture.menus[signal.name];
      if (!menu) continue;
      signal.value = menu.options[0];
      if (menu.options.length > 1)
        signal.bind = {input: 'select', name: menu.name, options: menu.options, labels: menu.labels};
    }
    for (const name of ['ink', 'paper', 'blue', 'red']) spec.signals.push({name, value: colours[name]});
    if (picture.kind === 'scatter') {
      const choice = Object.fromEntries(spec.signals.map((signal) => [signal.name, signal.value]));
      const {data, signals} = pointsOf(picture, choice, colours);
      for (const set of spec.data) if (set.name in data) set.values = data[set.name];
      for (const signal of spec.signals) if (signal.name in signals) signal.value = signals[signal.name];
      most = data.rows.length;
    }
    return {spec, renderer: most > kPlainMarks ? 'canvas' : 'svg'};
  }

  // Other columns of a scatter were chosen.
  function chooseAgain(picture, view, colours) {
    const choice = {x: view.signal('x'), y: view.signal('y'), colour: view.signal('colour')};
    const {data, signals} = pointsOf(picture, choice, colours);
    for (const name in signals) view.signal(name, signals[name]);
    for (const name in data) view.data(name, data[name]);
    view.runAsync();
  }

  const widthOf = (place) => Math.max(240, place.clientWidth);
  const isNarrow = (place) => widthOf(place) < kNarrow;

  function drawWithVega(picture, place, menus) {
    const colours = theme();
    const {spec, renderer} = specificationOf(picture, colours);
    spec.signals.unshift({name: 'narrow', value: isNarrow(place)});
    const view = new vega.View(vega.parse(spec, vegaConfig(colours), {ast: true}),
      {expr: vega.expressionInterpreter, renderer, hover: false});
    view.width(widthOf(place)).initialize(place, menus).run();
    if (picture.kind === 'scatter') {
      view.addSignalListener('picked', (_, pose) => showPose(pose));
      for (const name of ['x', 'y', 'colour']) {
        view.addSignalListener(name, () => chooseAgain(picture, view, colours));
      }
    }
    return {
      resize: () => view.signal('narrow', isNarrow(place)).width(widthOf(place)).run(),
      read: () => Object.fromEntries(Object.keys(picture.menus).map((name) => [name, view.signal(name)])),
      take: (values) => { for (const name in values) view.signal(name, values[name]); view.run(); },
      end: () => view.finalize(),
    };
  }

  // ------------------------------------------------------------------------------------------------ the arm in 3-D
  const workspaces = [];
  function showPose(pose) {
    if (pose !== null && pose !== undefined) workspaces.forEach((workspace) => workspace.select(pose));
  }

  function lines(points, colour, opacity) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.Float32BufferAttribute(points, 3));
    return new THREE.LineSegments(geometry,
      new THREE.LineBasicMaterial({color: colour, transparent: opacity < 1, opacity}));
  }

  function rod(from, to, radius, material) {
    const along = new THREE.Vector3().subVectors(to, from);
    const mesh = new THREE.Mesh(new THREE.CylinderBufferGeometry(radius, radius, along.length(), 12), material);
    mesh.position.copy(from).addScaledVector(along, 0.5);
    mesh.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along.normalize());
    return mesh;
  }

  // Joints and links of one pose: the flange in the second colour.
  function armOf(polyline, size, colours) {
    const group = new THREE.Group();
    const link = new THREE.MeshLambertMaterial({color: colours.blue});
    const flange = new THREE.MeshLambertMaterial({color: colours.red});
    const points = [];
    for (let i = 0; i + 2 < polyline.length; i += 3)
      points.push(new THREE.Vector3(polyline[i], polyline[i + 1], polyline[i + 2]));
    points.forEach((point, i) => {
      const last = i + 1 === points.length;
      const ball = new THREE.Mesh(new THREE.SphereBufferGeometry(0.017 * size, 16, 12), last ? flange : link);
      ball.position.copy(point);
      group.add(ball);
      if (!last && point.distanceTo(points[i + 1]) > 0) group.add(rod(point, points[i + 1], 0.008 * size, link));
    });
    return group;
  }

  // Each residual as a line from where the model sees the point, `factor` times as long, with a head.
  function arrowsOf(rows, factor, size, colours) {
    const group = new THREE.Group();
    const sets = [[], []];
    const head = new THREE.ConeBufferGeometry(0.006 * size, 0.018 * size, 6);
    const up = new THREE.Vector3(0, 1, 0), from = new THREE.Vector3(), along = new THREE.Vector3();
    const heads = [0, 1].map((k) => new THREE.InstancedMesh(head,
      new THREE.MeshLambertMaterial({color: k ? colours.red : colours.blue}),
      Math.max(1, rows.heldOut.reduce((n, value) => n + (value === k), 0))));
    const used = [0, 0], frame = new THREE.Object3D();
    rows.x.forEach((_, i) => {
      const k = rows.heldOut[i];
      from.set(rows.x[i], rows.y[i], rows.z[i]);
      along.set(rows.dx[i], rows.dy[i], rows.dz[i]).multiplyScalar(factor);
      sets[k].push(from.x, from.y, from.z, from.x + along.x, from.y + along.y, from.z + along.z);
      frame.position.copy(from).add(along);
      frame.quaternion.setFromUnitVectors(up, along.lengthSq() > 0 ? along.normalize() : up);
      frame.updateMatrix();
      heads[k].setMatrixAt(used[k]++, frame.matrix);
    });
    heads.forEach((mesh, k) => { mesh.count = used[k]; mesh.frustumCulled = false; if (used[k]) group.add(mesh); });
    sets.forEach((points, k) => { if (points.length) group.add(lines(points, k ? colours.red : colours.blue, 0.9)); });
    return group;
  }

  function boxOf(box, colours) {
    const group = new THREE.Group();
    const solid = new THREE.BoxBufferGeometry(box.size[0], box.size[1], box.size[2]);
    group.add(new THREE.Mesh(solid, new THREE.MeshLambertMaterial({color: colours.red, transparent: true, opacity: 0.15})));
    group.add(new THREE.LineSegments(new THREE.EdgesGeometry(solid), new THREE.LineBasicMaterial({color: colours.red})));
    group.position.fromArray(box.at);
    group.quaternion.fromArray(box.turn);
    return group;
  }

  // A labelled control: a menu or a slider; changed by keys as by the pointer.
  function control(menus, name, element) {
    const label = document.createElement('label');
    const text = document.createElement('span');
    text.textContent = name;
    label.append(text, element);
    menus.append(label);
    return element;
  }

  function menuOf(entries) {
    const select = document.createElement('select');
    entries.forEach(([value, text]) => select.add(new Option(text, value)));
    return select;
  }

  function drawInSpace(picture, place, menus) {
    const colours = theme();
    const {arms, rows, boxes, reach} = picture.data;
    const size = reach.size;
    let renderer;
    try {
      renderer = new THREE.WebGLRenderer({antialias: true, preserveDrawingBuffer: true});
    } catch (error) {
      place.textContent = 'This browser draws nothing in three dimensions (WebGL is off); the table has the numbers.';
      return {resize() {}, read: () => ({}), take() {}, end: nothing};
    }
    renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    renderer.setClearColor(colours.paper);
    place.append(renderer.domElement);
    const scene = new THREE.Scene();
    THREE.Object3D.DefaultUp.set(0, 0, 1);
    const camera = new THREE.PerspectiveCamera(38, 1, 0.01 * size, 50 * size);
    camera.up.set(0, 0, 1);
    const middle = new THREE.Vector3().fromArray(reach.middle);
    const controls = new THREE.OrbitControls(camera, renderer.domElement);
    controls.enableKeys = false;
    const render = () => renderer.render(scene, camera);
    const lookFrom = (x, y, z) => {
      camera.position.set(x, y, z).normalize().multiplyScalar(1.4 * size).add(middle);
      controls.target.copy(middle);
      controls.update();
      render();
    };
    scene.add(new THREE.AmbientLight(0xffffff, 0.65));
    const lamp = new THREE.DirectionalLight(0xffffff, 0.6);
    lamp.position.set(1, -1.5, 2);
    scene.add(lamp);
    const floor = new THREE.GridHelper(2 * size, 20, colours.line, colours.line);
    floor.rotation.x = Math.PI / 2;
    scene.add(floor, new THREE.AxesHelper(0.12 * size));
    boxes.forEach((box) => scene.add(boxOf(box, colours)));

    const ghosts = [];
    arms.polylines.forEach((polyline) => {
      for (let i = 0; i + 5 < polyline.length; i += 3) ghosts.push(...polyline.slice(i, i + 6));
    });
    const faint = lines(ghosts, colours.ink, 0.08);
    faint.visible = !picture.settings.arrows;
    scene.add(faint);

    let arm = null, arrows = null;
    const pose = control(menus, 'pose ', menuOf(arms.names.map((name, i) => [i, name])));
    const drawArm = () => {
      if (arm) scene.remove(arm);
      if (arms.polylines[pose.value]) scene.add(arm = armOf(arms.polylines[pose.value], size, colours));
    };
    pose.addEventListener('input', () => { drawArm(); render(); });
    let slider = null;
    if (picture.settings.arrows) {
      slider = control(menus, 'arrows ', document.createElement('input'));
      Object.assign(slider, {type: 'range', min: 0, max: 4, step: 0.05});
      slider.value = Math.log10(picture.settings.arrows);
      const shown = document.createElement('output');
      slider.after(shown);
      const drawArrows = () => {
        const factor = Math.pow(10, slider.value);
        shown.textContent = ' ' + Number(factor.toPrecision(2)) + ' times as long';
        if (arrows) scene.remove(arrows);
        scene.add(arrows = arrowsOf(rows, factor, size, colours));
      };
      slider.addEventListener('input', () => { drawArrows(); render(); });
      drawArrows();
    }
    const side = control(menus, 'seen from ',
      menuOf([['1,-1.4,0.8', 'the corner'], ['0,-1,0.0001', 'the side'], ['1,0,0.0001', 'the front'], ['0,-0.0001,1', 'above']]));
    side.addEventListener('input', () => lookFrom(...side.value.split(',').map(Number)));
    const ghostBox = control(menus, 'all arms ', document.createElement('input'));
    Object.assign(ghostBox, {type: 'checkbox', checked: faint.visible});
    ghostBox.addEventListener('input', () => { faint.visible = ghostBox.checked; render(); });
    drawArm();

    const resize = () => {
      const width = widthOf(place), height = Math.round(Math.min(460, Math.max(280, 0.62 * width)));
      renderer.setSize(width, height);
      camera.aspect = width / height;
      camera.updateProjectionMatrix();
      render();
    };
    // A click near an arrow's foot picks its pose.
    const projected = new THREE.Vector3();
    let pressed = null;
    renderer.domElement.addEventListener('pointerdown', (event) => { pressed = [event.clientX, event.clientY]; });
    renderer.domElement.addEventListener('click', (event) => {
      if (!picture.settings.arrows || !pressed) return;
      if (Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 4) return;  // it was a turn
      const area = renderer.domElement.getBoundingClientRect();
      let nearest = 15, found = null;  // px
      rows.x.forEach((_, i) => {
        projected.set(rows.x[i], rows.y[i], rows.z[i]).project(camera);
        const right = area.left + (0.5 + 0.5 * projected.x) * area.width;
        const down = area.top + (0.5 - 0.5 * projected.y) * area.height;
        const distance = Math.hypot(event.clientX - right, event.clientY - down);
        if (distance < nearest) { nearest = distance; found = rows.pose[i]; }
      });
      showPose(found);
    });
    resize();
    lookFrom(1, -1.4, 0.8);
    controls.addEventListener('change', render);
    const workspace = {
      select: (number) => {
        const i = arms.poses.indexOf(number);
        if (i < 0) return;
        pose.value = i;
        drawArm();
        render();
      },
    };
    workspaces.push(workspace);
    return {
      resize,
      read: () => ({pose: pose.value}),
      take: (values) => { if ('pose' in values) { pose.value = values.pose; drawArm(); render(); } },
      end: () => { workspaces.splice(workspaces.indexOf(workspace), 1); controls.dispose(); renderer.dispose(); },
    };
  }

  // ------------------------------------------------------------------------------------------------------- the page
  const drawn = new Map();  // figure: its picture
  const nothing = () => {};

  // A picture that fails leaves its table, and the others.
  function drawnOrExcused(picture, place, menus) {
    try {
      return picture.kind === 'workspace' ? drawInSpace(picture, place, menus) : drawWithVega(picture, place, menus);
    } catch (error) {
      console.error(picture.kind + ': ' + error.message);
      place.textContent = 'This picture cannot be drawn here; the table has the numbers.';
      return {resize() {}, read: () => ({}), take() {}, end: nothing};
    }
  }

  const tablesOf = (figure) => figure.querySelectorAll('details');

  function draw(figure) {
    const place = figure.querySelector('.place'), menus = figure.querySelector('.menus');
    const before = drawn.get(figure);
    const values = before ? before.read() : {};
    if (before) before.end();
    place.textContent = '';
    menus.textContent = '';
    const picture = JSON.parse(figure.querySelector('script').textContent);
    const now = drawnOrExcused(picture, place, menus);
    if (before) now.take(values);
    else if (now.end === nothing) tablesOf(figure).forEach((table) => { table.open = true; });
    drawn.set(figure, now);
    menus.querySelectorAll('.vega-bind-name').forEach((name) => {
      const input = name.parentElement.querySelector('select');
      if (input) input.setAttribute('aria-label', name.textContent);
    });
    document.documentElement.dataset.drawn = drawn.size;
  }

  const figures = [...document.querySelectorAll('figure.picture')];
  const near = new Set();  // figures on the screen or next to it, not drawn yet
  let isDrawing = false;

  // One after the other, so that the page answers in between.
  function drawNext() {
    const next = figures.find((figure) => near.has(figure));
    isDrawing = next !== undefined;
    if (!isDrawing) {
      document.documentElement.dataset.ready = 'yes';
      if (performance.getEntriesByName('drawn').length === 0) performance.mark('drawn');
      return;
    }
    near.delete(next);
    draw(next);
    setTimeout(drawNext, 0);
  }

  // A figure in a section that is folded is not near until it is opened.
  const watch = new IntersectionObserver((entries) => {
    for (const {target, isIntersecting} of entries) {
      if (isIntersecting && !drawn.has(target)) near.add(target);
      else near.delete(target);
    }
    if (!isDrawing) drawNext();
  }, {rootMargin: '50px'});

  // What was folded meanwhile has no width; it is drawn anew when it is opened.
  const isHidden = (figure) => figure.parentElement.closest('details:not([open])') !== null;
  function onEachDrawn(change) {
    for (const figure of [...drawn.keys()]) {
      if (!isHidden(figure)) {
        change(figure);
        continue;
      }
      drawn.get(figure).end();
      drawn.delete(figure);
    }
  }
  const redraw = () => onEachDrawn(draw);

  // On paper nothing can be opened: every section is, with its pictures; tables of pictures stay as they are.
  const folded = 'body > details:not([open])';
  let opened = [];
  function unfold() {
    printing = true;
    opened = [...document.querySelectorAll(folded)];
    opened.forEach((section) => { section.open = true; });
    near.clear();
    redraw();
    figures.filter((figure) => !drawn.has(figure)).forEach(draw);
  }

  function fold() {
    printing = false;
    opened.forEach((section) => { section.open = false; });
    redraw();
  }

  document.documentElement.dataset.drawn = 0;  // from here on, room is kept for what is not drawn yet (page.css)
  figures.forEach((figure) => {
    tablesOf(figure).forEach((table) => { table.open = false; });
    watch.observe(figure);
  });
  darkness.addEventListener('change', redraw);
  window.addEventListener('beforeprint', unfold);
  window.addEventListener('afterprint', fold);
  let soon = 0;
  window.addEventListener('resize', () => {
    clearTimeout(soon);
    soon = setTimeout(() => onEachDrawn((figure) => drawn.get(figure).resize()), 150);
  });
  if (figures.length === 0) drawNext();
})();
