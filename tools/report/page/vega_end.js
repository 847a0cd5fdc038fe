  Object.assign(made['vega-dataflow'].transforms, made['vega-transforms'], made['vega-view-transforms'],
    made['vega-encode']);
  return {
    parse: made['vega-parser'].parse,
    View: made['vega-view'].View,
    expressionInterpreter: made['vega-interpreter'].expressionInterpreter,
  };
})();
