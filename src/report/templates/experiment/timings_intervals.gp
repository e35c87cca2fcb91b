# one_LF, one_RS, one_RA: the share of a single interval
@canvas 1040,600
set multiplot layout 3,1
do for [loop in 'RS LF RA'] {
  one = value('one_'.loop)
  @panel
  set xlabel loop eq 'RA' ? 'time between two reads [ms]' : ''
  set ylabel 'share'
  set logscale y
  set xrange [0:4.4]
  set yrange [0.5*one:1]
  do for [peak = 1:3] { set arrow peak from peak, graph 0 to peak, graph 1 nohead dt 2 lw 1.6 lc rgb REFERENCE }
  if (loop ne 'RS') { unset arrow }
  plot $data using (1e-3*$1):(column(loop.' [1]')) @bars fc rgb value(loop) title loop, \
    NaN @dashed lc rgb REFERENCE title loop eq 'RS' ? 'peaks A, B, C: 1, 2, 3 ms' : ''
}
