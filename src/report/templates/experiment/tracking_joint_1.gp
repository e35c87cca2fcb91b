@canvas 900,630
set multiplot layout 2,1 title 'Joint 1, 18.32 s, rate limiter on in all' @heading
@panel
set xlabel 't [s]'
set ylabel 'dq [rad/s]'
plot $data using 1:"rs [rad/s]" @line lc rgb RS title 'synchronous + low-pass', \
  '' using 1:"ra [rad/s]" @line lc rgb RA title 'asynchronous + generator', \
  '' using 1:"ra_low_pass [rad/s]" @line lc rgb series(4) title 'asynchronous + generator + low-pass', \
  '' using 1:"planned [rad/s]" @dashed lc rgb REFERENCE title 'planned'
@panel
set xlabel 'f [Hz]'
set ylabel 'PSD of dq [(rad/s)^2/Hz]'
set logscale xy
plot $spectrum using 1:"rs" @line lc rgb RS title 'synchronous + low-pass', \
  '' using 1:"ra" @line lc rgb RA title 'asynchronous + generator', \
  '' using 1:"ra_low_pass" @line lc rgb series(4) title 'asynchronous + generator + low-pass', \
  '' using 1:"rs_quiet" @dashed lc rgb REFERENCE title 'synchronous, timing faults off'
