/* Vega, Copyright 2015-2021 UW Interactive Data Lab, BSD-3-Clause; with parts of d3, Copyright 2010-2022 Mike Bostock:
Permission to use, copy, modify, and/or distribute this software for any purpose with or without fee is hereby granted,
provided that the above copyright notice and this permission notice appear in all copies. THE SOFTWARE IS PROVIDED "AS IS"
AND THE AUTHOR DISCLAIMS ALL WARRANTIES WITH REGARD TO THIS SOFTWARE INCLUDING ALL IMPLIED WARRANTIES OF MERCHANTABILITY
AND FITNESS. IN NO EVENT SHALL THE AUTHOR BE LIABLE FOR ANY SPECIAL, DIRECT, INDIRECT, OR CONSEQUENTIAL DAMAGES OR ANY
DAMAGES WHATSOEVER RESULTING FROM LOSS OF USE, DATA OR PROFITS, WHETHER IN AN ACTION OF CONTRACT, NEGLIGENCE OR OTHER
TORTIOUS ACTION, ARISING OUT OF OR IN CONNECTION WITH THE USE OR PERFORMANCE OF THIS SOFTWARE. */
// What follows are modules of Vega as their package ships them, each calling define() (AMD). `next` names the one to come.
var vega = (function () {
  const made = {};
  let next = '';
  function define(needs, make) {
    made[next] = {};
    make(...needs.map((need) => (need === 'exports' ? made[next] : made[need])));
  }
  define.amd = true;
