// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace hrp::diagnosis {

// Two accents that stay apart for colour-blind readers (orange: before, blue: after); contrast at least 4.5 : 1 for
// text in light and dark.
inline constexpr const char* kReportStyle = R"css(
:root{color-scheme:light dark;--ink:#1b1f24;--soft:#57606a;--page:#fff;--card:#f5f6f8;--line:#d5d9df;--before:#b4500a;
--after:#0b5fa8;--heat:#a3320b;--good:#1a6b34;--warn:#8a5a00}
@media(prefers-color-scheme:dark){:root{--ink:#e8eaed;--soft:#a5adb8;--page:#14171b;--card:#1e2329;--line:#39414b;
--before:#ff9d57;--after:#6cb4ff;--heat:#ff8a5c;--good:#66c98a;--warn:#e3b341}}
*{box-sizing:border-box}body{margin:0;background:var(--page);color:var(--ink);font:16px/1.55 system-ui,sans-serif}
main{max-width:68rem;margin:0 auto;padding:1.5rem 1.2rem 4rem}h1{font-size:1.5rem;line-height:1.3;margin:.2rem 0 1rem;overflow-wrap:anywhere}
h2{font-size:1.25rem;margin:2.6rem 0 .6rem;padding-top:.8rem;border-top:1px solid var(--line)}h3{font-size:1.05rem;margin:1rem 0 .3rem}
h4{font-size:.95rem;margin:.9rem 0 .2rem;color:var(--soft);font-weight:600}
.over,.small{color:var(--soft);font-size:.9rem;margin:.2rem 0}.lead{font-size:1.2rem;line-height:1.5;max-width:52rem;margin:.5rem 0}
.badge{display:inline-block;border:2px solid currentColor;border-radius:.4rem;padding:.05rem .6rem;margin-right:.4rem;font-size:1.1rem}
.badge.no_mismatch,.badge.explained{color:var(--good)}.badge.partly_explained,.badge.unexplained{color:var(--warn)}
.cards{display:grid;gap:.8rem;grid-template-columns:repeat(auto-fit,minmax(19rem,1fr));margin:.8rem 0}
.card{background:var(--card);border-left:4px solid var(--after);border-radius:.3rem;padding:.5rem 1rem}.card h3{margin:.2rem 0}
.card.warn{border-color:var(--warn)}.place{font-weight:400;color:var(--soft);margin-left:.6rem}
table{border-collapse:collapse;font-size:.92rem;margin:.6rem 0}th,td{text-align:left;padding:.28rem .8rem .28rem 0;border-bottom:1px solid var(--line);vertical-align:top}
th{color:var(--soft);font-weight:600}td svg{width:160px;height:16px;display:block}tr.won td{background:var(--card)}code,pre{font-family:ui-monospace,monospace;font-size:.88em}
code{overflow-wrap:anywhere}pre{background:var(--card);padding:.7rem 1rem;overflow-x:auto;border-radius:.3rem}
.wide{overflow-x:auto}.map svg{min-width:760px;width:100%;height:auto}.plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(27rem,100%),1fr));gap:.8rem}
.plots svg{width:100%;max-width:34rem;height:auto}figure{margin:0}figcaption{font-size:.95rem}.bars svg{max-width:640px;width:100%;height:auto}
details{margin:.5rem 0}summary{cursor:pointer;font-weight:600;padding:.25rem 0}summary:focus-visible,[tabindex]:focus-visible{outline:3px solid var(--after);outline-offset:2px}
.num{white-space:nowrap}.unsure{color:var(--soft);font-style:italic}.meter{display:inline-block;width:60px;height:.6em;margin-right:.5em;border:1px solid var(--line);background:linear-gradient(var(--after),var(--after)) no-repeat left/calc(var(--p)*100%) 100%}
.legend{display:flex;align-items:center;gap:2px;font-size:.85rem;color:var(--soft)}.legend span{margin:0 .4rem}.swatch{width:20px;height:12px}
.key{font-size:.9rem}.line{display:inline-block;width:1.8em;height:0;border-top:3px solid var(--ink);vertical-align:middle;margin:0 .2em 0 .8em}
.line.recorded{border-color:var(--soft);border-top-width:5px}.line.before{border-color:var(--before);border-top-style:dashed}.line.after{border-color:var(--after)}
svg text{font:11px system-ui,sans-serif;fill:var(--ink)}svg .kind{fill:var(--soft)}svg .strong{font-weight:600}
.grid{stroke:var(--line);stroke-width:.6}.floor{stroke:var(--good);stroke-width:2}.mark{fill:var(--soft);opacity:.75}
.heat{fill:var(--heat)}.h1{opacity:.1}.h2{opacity:.2}.h3{opacity:.3}.h4{opacity:.41}.h5{opacity:.52}.h6{opacity:.64}.h7{opacity:.76}.h8{opacity:.88}
.gap{fill:var(--line)}.curve{fill:none;stroke-width:1.4;stroke-linejoin:round}.curve.recorded{stroke:var(--soft);stroke-width:3;opacity:.7}
.curve.before{stroke:var(--before);stroke-dasharray:5 3}.curve.after{stroke:var(--after)}.curve.law{stroke:var(--ink);stroke-width:2}
.dot.before{fill:var(--before);opacity:.55}.dot.after{fill:var(--after);opacity:.45}.bar.before{fill:var(--before)}.bar.after{fill:var(--after)}
.span{stroke:var(--after);stroke-width:3}.value{fill:var(--after)}
@media print{details{display:block}main{max-width:none}}
)css";

}  // namespace hrp::diagnosis
