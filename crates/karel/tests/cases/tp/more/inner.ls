/PROG  INNER
/ATTR
OWNER		= MNEDITOR;
DEFAULT_GROUP	= 1,*,*,*,*;
/MN
   1:L P[1] 50mm/sec FINE TB .05sec,CALL NOTED("Number"=AR[1],"Text"='early') ;
/POS
P[1:"here"]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = 900.000 mm,	Y = 0.000 mm,	Z = 700.000 mm,
	W = 180.000 deg,	P = 0.000 deg,	R = 0.000 deg
};
/END
