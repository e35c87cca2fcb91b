# Cycles: served, held, none (without motion), longest_loss (in a row), cycles_per_span (a row of the table), most (held or dropped in a row of it). dropped: commands.
# written: 1 if a command was; longest_us: largest d_EXT; lowest_rate: of the success rate.
share(n) = served + held > 0 ? sprintf('%.0f (%.4g %%)', n, 100.0*n/(served + held)) : sprintf('%.0f', n)
@canvas 1200,1000
set multiplot layout 4,1 title names[1] @heading
set style fill solid noborder
@run_marks
@panel
# To the right of the panel, where it hides nothing.
set key at screen 0.86, graph 0.95 left top vertical Left reverse samplen 2 spacing 1.3
set lmargin 11; set rmargin 22; set tmargin 3; set bmargin 3
set xrange [begin:end]
set title sprintf('%.0f cycles of motion: %s served, %s held, at most %.0f in a row; %.0f without motion', served + held, share(served), share(held), longest_loss, none)
set ylabel 'share / %'
set yrange [0:100]
plot $data using 1:(100) with fillsteps fc rgb QUIET title 'no motion', '' using 1:3 with fillsteps fc rgb HELD title 'held', \
  '' using 1:2 with fillsteps fc rgb SERVED title 'served', NaN with lines lw 2 lc rgb ABORT title aborted ? 'abort' : ''
set title sprintf('per %.0f cycles: cycles held, %.0f in all; commands dropped, %.0f in all', cycles_per_span, held, dropped)
set ylabel 'count'
set yrange [0:1.15*most]
plot $data using 1:4 with impulses lw 2.5 lc rgb HELD title 'held cycles', \
  '' using 1:($5 > 0 ? $5 : NaN) with points pt 7 ps 0.5 lc rgb DESIRED title 'dropped commands'
set title longest_us > 0 ? sprintf('d_EXT, read to write: at most %.4g µs', longest_us) : \
  written ? 'd_EXT, read to write: 0 µs, no cost is simulated (tick.cost)' : 'd_EXT, read to write: no command was written'
set ylabel 'd_EXT / µs'
set yrange [0:(longest_us > 0 ? 1.2*longest_us : 1)]
plot $delay using 2:3 with lines lw 1.2 lc rgb DESIRED notitle
set title 'control_command_success_rate: share of the last 100 commands received, while a motion runs'
set xlabel 'time / s' offset 0,0.6
set ylabel 'success rate'
# The axis begins near the lowest rate, so that a loss of one command in a hundred is visible.
set yrange [(lowest_rate < 0.95 ? (lowest_rate > 0.05 ? lowest_rate - 0.05 : 0) : 0.9):1.02]
plot $rate using 2:3 with lines lw 1.5 lc rgb DESIRED notitle
