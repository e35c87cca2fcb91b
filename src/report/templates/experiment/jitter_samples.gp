@canvas 900,930
set multiplot layout 3,1 title 'Sampling jitter' @heading
@panel
set title 'Samples displaced in time, at 1 rad/s (40 times the jitter, to be visible)'
set xlabel 't [ms]'
set ylabel 'q - q*(500 ms) [mrad]'
plot $displaced using "filed at [ms]":"intended [mrad]" @line lc rgb REFERENCE title 'intended q*(t)', \
  '' using "filed at [ms]":"sampled [mrad]" @line lc rgb RS title 'filed at kT: what INT reconstructs', \
  '' using "filed at [ms]":"sampled [mrad]" @points lc rgb RS notitle, \
  '' using "sampled at [ms]":"sampled [mrad]" @points lc rgb RA title 'sampled at kT + dt(k)'
@panel
set title 'The reconstructed reference against the intended one, jitter 4 us'
set xlabel 't [ms]'
set ylabel 'q_d - q* [urad]'
set xrange [470:530]
plot 0 @line lc rgb REFERENCE title 'intended', \
  $data using (1e3*column("t [s]")):(1e6*(column("reconstructed q [rad]") - column("intended q [rad]"))) @line lc rgb RS title 'reconstructed'
@panel
set title 'One sample 4 us late at 1 rad/s; the next increment leaves the cone of admissible ones'
set xlabel 'cycle'
set ylabel 'increment - intended [urad]'
plot $cone using "cycle":"most [urad]" @line lc rgb LIMIT title 'admissible after the displaced sample', \
  '' using "cycle":"least [urad]" @line lc rgb LIMIT notitle, \
  '' using "cycle":"increment [urad]" @line lc rgb RA title 'increments', \
  '' using "cycle":"increment [urad]" @points lc rgb RA notitle, \
  '' using "cycle":"refused [urad]" @points lc rgb RS title 'refused'
